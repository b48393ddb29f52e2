"""Arms that are touched: in MuJoCo with a known force, and public recordings with weights and hands."""
