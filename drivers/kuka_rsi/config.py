"""RSI_EthernetConfig.xml: what a KUKA controller sends, and what it expects in return.

The controller reads this file, and the driver reads a copy, so that both agree on the port, names and types.
Telegrams name their content after the tags: `AK.A1` is attribute A1 of element AK, `DEF_AIPos` is the
controller's internal element AIPos with all axes, and a tag without a dot is an element with a text.
"""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from exidyn.quoting import xml_document

from ..errors import BadSettings

TYPES = ("BOOL", "STRING", "LONG", "DOUBLE")
INTERNAL = "INTERNAL"
CHANNELS = 64
"""Number of channels in each direction."""
OWN = "DEF_"
"""Prefix of the tags of the controller's internal values."""
AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
EXTERNAL_AXES = ("E1", "E2", "E3", "E4", "E5", "E6")


@dataclass(frozen=True)
class Element:
    """One line of SEND or RECEIVE."""

    tag: str  # name in the telegram
    kind: str  # one of `TYPES`
    index: int = 0  # number of the channel in the RSI context; zero for the controller's internal values
    hold: bool = False  # whether the controller keeps the last value if no answer comes in time (HOLDON)


@dataclass(frozen=True)
class RsiConfig:
    """Content of the file."""

    address: str  # address of this computer to which the controller sends (IP_NUMBER)
    port: int  # port of this computer to which the controller sends
    sentype: str  # type that answers must have (SENTYPE)
    only_send: bool  # whether the controller expects no answers (ONLYSEND)
    send: tuple[Element, ...]  # elements that the controller sends
    receive: tuple[Element, ...]  # elements that the controller receives
    protocol: str = "UDP"  # UDP; a KRC2 may also have TCP

    def sends(self, tag: str) -> bool:
        """Whether the controller sends a value; DEF_AIPos also sends `AIPos.A1`."""
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
    """Configuration that suits identification best, with address and port of this computer.

    With `only_send`, the controller's program moves the arm and this computer only listens. `torque` is
    whether a GEARTORQUE object is wired to channels 1 to 6 of SEND, `stop` whether channel 7 of RECEIVE is
    wired to a STOP object.
    """
    internal = [Element(f"{OWN}{name}", "DOUBLE") for name in ("RIst", "AIPos", "ASPos", "MACur")]
    internal.append(Element(f"{OWN}Delay", "LONG"))
    torques = (
        [Element(f"GearTorque.{axis}", "DOUBLE", k + 1) for k, axis in enumerate(AXES)] if torque else []
    )
    corrections = [Element(f"AK.{axis}", "DOUBLE", k + 1, hold=True) for k, axis in enumerate(AXES)]
    last = [Element("Stop", "BOOL", len(AXES) + 1, hold=True)] if stop else []
    return RsiConfig(address, port, sentype, only_send, (*internal, *torques), (*corrections, *last))


def read_config(path: Path | str) -> RsiConfig:
    """Read a configuration file. Raises BadSettings if a controller would not accept it."""
    try:
        root = ElementTree.fromstring(Path(path).read_bytes())
    except OSError as error:
        raise BadSettings(f"{path} cannot be read: {error.strerror}") from error
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BadSettings(
            f"{path} is not XML: {error}. Copy RSI_EthernetConfig.xml from the controller"
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


def _elements(path: Path | str, root: ElementTree.Element, section: str) -> tuple[Element, ...]:
    nodes = root.findall(f"{section}/ELEMENTS/ELEMENT")
    elements = tuple(_element(f"{path}: {section}", node) for node in nodes)
    for field in ("tag", "index"):
        values = [getattr(element, field) for element in elements if getattr(element, field)]
        twice = [value for value in values if values.count(value) > 1]
        if twice:
            raise BadSettings(f"{path}: {section} has {field} {twice[0]} twice")
    return elements


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
    r"""Text of RSI_EthernetConfig.xml.

    It belongs in C:\KRC\ROBOTER\Config\User\Common\SensorInterface on a KRC4 or KRC5, under the name in the
    ETHERNET object of the RSI context.
    """
    root = ElementTree.Element("ROOT")
    facts = {"IP_NUMBER": config.address, "PORT": str(config.port)}
    facts |= {"SENTYPE": config.sentype, "ONLYSEND": str(config.only_send).upper()}
    section = ElementTree.SubElement(root, "CONFIG")
    for name, text in facts.items():
        ElementTree.SubElement(section, name).text = text
    for direction, elements in (("SEND", config.send), ("RECEIVE", config.receive)):
        section = ElementTree.SubElement(ElementTree.SubElement(root, direction), "ELEMENTS")
        for element in elements:
            index = str(element.index) if element.index else INTERNAL
            attributes = {"TAG": element.tag, "TYPE": element.kind, "INDX": index}
            if direction == "RECEIVE":
                attributes["HOLDON"] = str(int(element.hold))
            ElementTree.SubElement(section, "ELEMENT", attributes)
    return xml_document(root, declaration=False)
