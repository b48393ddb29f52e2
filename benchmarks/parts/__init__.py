"""What the commands of this folder are made of: `parts/NAME/` belongs to `NAME.py`.

`figaroh/` and `regressor_floor.py` are what `speed.py` and `excite.py` compare with; `proof/` writes the page
of `diagnose_real.py`.
"""
