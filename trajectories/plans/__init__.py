"""A trajectory with its robot, limits and reasons: as a file, a page, a view, an export."""
