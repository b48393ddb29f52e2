"""The table of drivers: its page in the docs, and the drivers of installed packages."""

import re
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.drivers import DRIVERS, Arm, create, driver_class, explain, known_drivers
from exidyn.drivers.errors import BadDriver, UnknownDriver

from ..parts.installed_package import lay_out
from ..peers.driver_peers import peer_of

DOCS = Path(__file__).parents[2] / "docs"
ARM = Arm(("joint1",), np.full(1, -1.0), np.full(1, 1.0), np.full(1, 1.0))
MODULE = """
from dataclasses import dataclass
from exidyn.drivers import Driver
from exidyn.drivers.settings import setting

@dataclass(frozen=True)
class Settings:
    port: str = setting(..., "of the controller")

class Acme(Driver):
    '''A controller of Acme.'''
    Settings = Settings
    def open(self): ...
    def exchange(self, command): ...
    def close(self): ...

SOMETHING_ELSE = 3
"""


def rows(page, header):
    """Driver -> the rest of its row, of a table in the docs."""
    text = (DOCS / page).read_text()
    lines = text[text.index(header) :].split("\n\n")[0].splitlines()[2:]
    cells = [line.strip("| ").split(" | ", 1) for line in lines]
    return {name: rest for names, rest in cells for name in re.findall("`(.+?)`", names)}


def test_every_driver_has_a_row_in_the_docs_whose_page_is_about_it():
    pages = rows("record.md", "| driver | page |")
    assert set(pages) == set(DRIVERS)
    for name, cell in pages.items():
        linked = re.findall(r"\]\((.+?)\)", cell)
        assert linked or driver_class(name).simulated, name
        assert all(f"`{name}`" in (DOCS / page).read_text() for page in linked), name


def test_the_docs_state_of_every_driver_what_is_sent_while_it_is_read():
    assert set(rows("commissioning.md", "| driver | sent | so |")) == set(DRIVERS)


@pytest.mark.parametrize("name", DRIVERS)
def test_every_driver_declares_its_peer(name):
    assert peer_of(name).joints > 0


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Installs a package with one entry point; its modules are imported once, so each has another name."""

    def done(entry, text=MODULE):
        module = f"acme_robots_{abs(hash((entry, text)))}"
        lay_out(tmp_path, "exidyn.drivers", entry.replace("acme", module, 1), text, module)
        monkeypatch.syspath_prepend(tmp_path)
        return module.replace("_", "-")

    return done


def test_a_driver_of_an_installed_package_is_listed_and_made(install, capsys):
    package = install("cell7 = acme:Acme")
    assert known_drivers()["cell7"].package == package
    assert "cell7" not in DRIVERS
    assert main(["init", "--driver"]) == 0
    assert f"cell7        a driver of the package {package}" in capsys.readouterr().out
    assert "# of the controller; required\n# port =" in explain("cell7")
    assert type(create("cell7", {"port": "x"}, ARM)).__name__ == "Acme"


def test_nothing_is_imported_of_a_driver_that_is_not_asked_for(install, capsys):
    install("cell7 = acme:Acme", "raise OSError('no licence')")
    assert main(["init", "--driver"]) == 0
    assert "cell7" in capsys.readouterr().out
    with pytest.raises(UnknownDriver, match="cell7"):
        driver_class("nobody")


@pytest.mark.parametrize(
    ("entry", "text", "message"),
    [
        ("cell7 = acme:Acme", "import nothing_of_that_name", "No module named"),
        ("cell7 = acme:Acme", "raise OSError('no licence\\nfor today')", "OSError: no licence. Repair"),
        ("cell7 = acme:Misspelt", MODULE, "Misspelt"),
        ("cell7 = acme:SOMETHING_ELSE", MODULE, "no subclass of exidyn.drivers.Driver"),
        ("mock = acme:Acme", MODULE, "the name is taken"),
    ],
)
def test_a_driver_that_cannot_be_used_is_one_line_that_names_its_package(install, entry, text, message):
    package = install(entry, text)
    name = entry.split(" = ")[0]
    with pytest.raises(BadDriver) as error:
        create(name, {}, ARM)
    assert message in str(error.value)
    assert f"driver '{name}' of the package {package}" in str(error.value)
    assert "\n" not in str(error.value)
