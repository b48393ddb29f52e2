"""Find out what a robot arm's dynamics really are: excite, record, identify, diagnose.

The folders of the repository are linked in here, so that every tool sees one package.
"""

from importlib.metadata import version

__version__ = version("exidyn")
