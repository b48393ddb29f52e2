"""What is built and installed is the whole package, from a checkout without symbolic links too."""

import inspect
import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path
from shutil import copy, copytree, ignore_patterns

import pytest

import exidyn as ex

ROOT = Path(__file__).parents[1]
FOLDERS = ("acquire", "drivers", "identify", "trajectories")
OTHERS = ("pyproject.toml", "setup.py", "README.md", "LICENSE")
PROGRAM = """
import inspect, exidyn
from exidyn.identification.fit.fit import Fit
import exidyn.drivers.mock.driver, exidyn.acquire.command_line
assert inspect.signature(exidyn.identify).return_annotation is Fit
print(exidyn.drivers.mock.driver.__file__)
"""


def run(*command: str | Path, cwd: Path) -> str:
    """What a command prints that ends well; it imports from nowhere but from where it is installed."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def installed(folder: Path, *what: str | Path) -> Path:
    """Programs of a new environment with this package, and with what this one has besides."""
    venv.create(folder, symlinks=True)
    [packages] = folder.glob("lib/*/site-packages")
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        if not entry.name.startswith(("exidyn", "__editable__", "pip")):
            (packages / entry.name).symlink_to(entry)
    pip = (sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "--quiet")
    run(*pip, "--no-compile", "--no-deps", "--no-build-isolation", *what, cwd=folder)
    return folder / "bin"


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """The repository as `git clone -c core.symlinks=false` writes it, with links as text files."""
    pytest.importorskip("setuptools", "70.1", reason="older ones do not make wheels by themselves")
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("exidyn", *FOLDERS):
        copytree(ROOT / name, folder / name, symlinks=True, ignore=ignore_patterns("__pycache__"))
    for name in OTHERS:
        copy(ROOT / name, folder)
    for link in [path for path in folder.rglob("*") if path.is_symlink()]:
        target = os.readlink(link)
        link.unlink()
        link.write_text(target, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def built(checkout):
    """A source archive, and a wheel that is built from it."""
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", checkout / "dist", cwd=checkout)
    [archive], [wheel] = (list((checkout / "dist").glob(ending)) for ending in ("*.tar.gz", "*.whl"))
    return archive, wheel


def test_every_folder_with_python_files_is_a_package():
    """Otherwise it is missing in what is installed."""
    folders = {path.parent for top in FOLDERS for path in (ROOT / top).rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").is_file()] == []


@pytest.mark.slow
def test_archive_and_wheel_have_every_file(checkout, built):
    sources = {
        str(path.relative_to(checkout))
        for top in ("exidyn", *FOLDERS)
        for path in (checkout / top).rglob("*")
        if path.is_file()
    }
    with tarfile.open(built[0]) as archive, zipfile.ZipFile(built[1]) as wheel:
        packed = {name.partition("/")[2] for name in archive.getnames()}
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert sources - packed == set()
    packaged = {name.replace("identify/", "identification/", 1) for name in sources}
    assert names == {name if name.startswith("exidyn/") else f"exidyn/{name}" for name in packaged}


@pytest.mark.slow
def test_the_wheel_identifies_a_recording(built, tutorial, tmp_path):
    programs = installed(tmp_path / "venv", built[1])
    run(programs / "exidyn", "identify", tutorial / "run.mcap", "--output", "fit", cwd=tmp_path)
    assert "<html" in (tmp_path / "fit" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_an_editable_install_takes_the_checkout(checkout, tmp_path):
    programs = installed(tmp_path / "venv", "--editable", checkout)
    for folder in (tmp_path, checkout):
        assert Path(run(programs / "python", "-c", PROGRAM, cwd=folder)).is_relative_to(checkout)


def test_no_function_has_the_name_of_a_package():
    assert list(inspect.signature(ex.identify).parameters) == [
        "runs", "validate", "robot", "estimator", "filtering", "t", "q", "torque", "current", "degrees",
        "urdf", "payload", "mass", "com", "options",
    ]  # fmt: skip
    import exidyn.identification.recordings.recording
    from exidyn.identification import effects

    assert inspect.isfunction(exidyn.identify)
    assert inspect.ismodule(exidyn.identification.recordings.recording)
    assert effects.EFFECTS is ex.EFFECTS
