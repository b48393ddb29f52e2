"""A package of somebody else's, laid out as an installer does."""


def lay_out(folder, group, entry, text, module):
    """One module, and one entry point of a group; it is installed once the folder is on the path."""
    (folder / f"{module}.py").write_text(text)
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    name = module.replace("_", "-")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{entry}\n")
