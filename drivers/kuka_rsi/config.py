"""RSI_EthernetConfig.xml: what a KUKA controller sends, and what it expects in return.

The controller reads this file, and so does the driver, from a copy: both then mean the same port, names and
types. Telegrams name their content after the tags: `AK.A1` is attribute A1 of element AK, `DEF_AIPos` is the
controller's own element AIPos with all axes, and a tag without a dot is an element with a text.
"""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from exidyn.quoting import xml_attribute, xml_content

from ..errors import BadSettings

TYPES = ("BOOL", "STRING", "LONG", "DOUBLE")
INTERNAL = "INTERNAL"
CHANNELS = 64
"""Numbered channels in each direction."""
OWN = "DEF_"
"""What the tags of the controller's own values begin with."""
AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
EXTERNAL_AXES = ("E1", "E2", "E3", "E4", "E5", "E6")


@dataclass(frozen=True)
class Element:
    """One line of SEND or RECEIVE.

    Attributes:
        tag: Name in the telegram.
        kind: One of `TYPES`.
        index: Number of the channel in the RSI context; zero for the controller's own values.
        hold: Whether the controller keeps the last value when no answer came in time (HOLDON).
    """

    tag: str
    kind: str
    index: int = 0
    hold: bool = False


@dataclass(frozen=True)
class RsiConfig:
    """The whole file.

    Attributes:
        address: Where the controller sends to: an address of this computer (IP_NUMBER).
        port: Where it sends to.
        sentype: What answers must call themselves (SENTYPE).
        only_send: Whether the controller expects no answers (ONLYSEND).
        send: From the controller.
        receive: To the controller.
        protocol: UDP; a KRC2 may also have TCP.
    """

    address: str
    port: int
    sentype: str
    only_send: bool
    send: tuple[Element, ...]
    receive: tuple[Element, ...]
    protocol: str = "UDP"

    def sends(self, tag: str) -> bool:
        """Whether a value comes: `AIPos.A1` does for DEF_AIPos too."""
        tags = {element.tag for element in self.send}
        return tag in tags or f"{OWN}{tag.split('.')[0]}" in tags

    def corrections(self) -> tuple[str, ...]:
        """First parts of the tags that correct all axes, such as AK."""
        tags = [element.tag for element in self.receive if element.kind == "DOUBLE"]
        firsts = dict.fromkeys(tag.split(".")[0] for tag in tags if tag.endswith(".A1"))
        return tuple(first for first in firsts if not first.startswith(OWN))


def standard_config(
    address: str,
    port: int = 49152,
    sentype: str = "ImFree",
    only_send: bool = False,
    torque: bool = False,
    stop: bool = True,
) -> RsiConfig:
    """The configuration that suits identification best, for an address of this computer.

    Args:
        address: Address of this computer, in the controller's network.
        port: Where the driver listens.
        sentype: What its answers call themselves.
        only_send: Whether the controller's program moves and this computer listens only.
        torque: Whether a GEARTORQUE object is wired to channels 1 to 6 of what is sent.
        stop: Whether channel 7 of what is received is wired to a STOP object.
    """
    own = [Element(f"{OWN}{name}", "DOUBLE") for name in ("RIst", "AIPos", "ASPos", "MACur")]
    own.append(Element(f"{OWN}Delay", "LONG"))
    torques = (
        [Element(f"GearTorque.{axis}", "DOUBLE", k + 1) for k, axis in enumerate(AXES)] if torque else []
    )
    corrections = [Element(f"AK.{axis}", "DOUBLE", k + 1, hold=True) for k, axis in enumerate(AXES)]
    last = [Element("Stop", "BOOL", len(AXES) + 1, hold=True)] if stop else []
    return RsiConfig(address, port, sentype, only_send, (*own, *torques), (*corrections, *last))


def read_config(path: Path | str) -> RsiConfig:
    """Read a configuration file. Raises BadSettings if a controller would not take it either."""
    try:
        root = ElementTree.fromstring(Path(path).read_bytes())
    except OSError as error:
        raise BadSettings(f"{path} cannot be read: {error.strerror}") from error
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BadSettings(
            f"{path} is no XML: {error}. Copy RSI_EthernetConfig.xml from the controller"
        ) from error
    config = RsiConfig(
        address=_text(path, root, "IP_NUMBER"),
        port=_integer(f"{path}: PORT", _text(path, root, "PORT"), 1, 65535),
        sentype=_text(path, root, "SENTYPE"),
        only_send=_flag(f"{path}: ONLYSEND", _text(path, root, "ONLYSEND", "FALSE")),
        send=_elements(path, root, "SEND"),
        receive=_elements(path, root, "RECEIVE"),
        protocol=_text(path, root, "PROTOCOL", "UDP").upper(),
    )
    if config.protocol != "UDP":
        raise BadSettings(f"{path}: PROTOCOL is {config.protocol}; the driver uses UDP only")
    return config


def _text(path: Path | str, root: ElementTree.Element, name: str, default: str | None = None) -> str:
    text = (root.findtext(f"CONFIG/{name}") or "").strip()
    if not text and default is None:
        raise BadSettings(
            f"{path} has no CONFIG/{name}. Is it the RSI_EthernetConfig.xml of the RSI context?"
        )
    return text or str(default)


def _integer(where: str, text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text[:9]) <= high:
        raise BadSettings(f"{where} is '{text}'; valid are {low} to {high}")
    return int(text)


def _flag(where: str, text: str) -> bool:
    if text.upper() not in ("TRUE", "FALSE", "1", "0"):
        raise BadSettings(f"{where} is '{text}'. Valid: TRUE, FALSE")
    return text.upper() in ("TRUE", "1")


def _elements(path: Path | str, root: ElementTree.Element, way: str) -> tuple[Element, ...]:
    found = tuple(_element(f"{path}: {way}", one) for one in root.findall(f"{way}/ELEMENTS/ELEMENT"))
    for what in ("tag", "index"):
        names = [getattr(element, what) for element in found if getattr(element, what)]
        twice = [name for name in names if names.count(name) > 1]
        if twice:
            raise BadSettings(f"{path}: {way} has {what} {twice[0]} twice")
    return found


def _element(where: str, element: ElementTree.Element) -> Element:
    tag, kind = element.get("TAG", "").strip(), element.get("TYPE", "").strip().upper()
    if not re.fullmatch(r"\w+(\.\w+)?", tag, re.ASCII):
        raise BadSettings(f"{where}: TAG is '{tag}'; expected a name, or two with a dot between")
    where = f"{where}: {tag}"
    if kind not in TYPES:
        raise BadSettings(f"{where} has TYPE '{kind}'. Valid: {', '.join(TYPES)}")
    index = element.get("INDX", "").strip()
    number = 0 if index.upper() == INTERNAL else _integer(f"{where}: INDX", index, 1, CHANNELS)
    return Element(tag, kind, number, _flag(f"{where}: HOLDON", element.get("HOLDON", "0").strip()))


def config_text(config: RsiConfig) -> str:
    r"""The text of RSI_EthernetConfig.xml.

    It goes to C:\KRC\ROBOTER\Config\User\Common\SensorInterface on a KRC4 or KRC5, under the name that
    the ETHERNET object of the RSI context has.
    """
    facts = {"IP_NUMBER": config.address, "PORT": str(config.port)}
    facts |= {"SENTYPE": config.sentype, "ONLYSEND": str(config.only_send).upper()}
    lines = ["<ROOT>", "  <CONFIG>"]
    lines += [f"    <{name}>{xml_content(text)}</{name}>" for name, text in facts.items()]
    lines += ["  </CONFIG>"]
    for way, elements in (("SEND", config.send), ("RECEIVE", config.receive)):
        lines += [f"  <{way}>", "    <ELEMENTS>"]
        for element in elements:
            index = str(element.index) if element.index else INTERNAL
            hold = f' HOLDON="{int(element.hold)}"' * (way == "RECEIVE")
            tag = xml_attribute(element.tag)
            lines.append(f'      <ELEMENT TAG={tag} TYPE="{element.kind}" INDX="{index}"{hold} />')
        lines += ["    </ELEMENTS>", f"  </{way}>"]
    return "\n".join([*lines, "</ROOT>"]) + "\n"
