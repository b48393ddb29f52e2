"""A configuration as the file that a controller reads."""

from xml.sax.saxutils import escape, quoteattr

from .config import INTERNAL, Element, RsiConfig


def config_text(config: RsiConfig, generation: str = "KRC4") -> str:
    r"""The text of RSI_EthernetConfig.xml.

    It goes to C:\KRC\ROBOTER\Config\User\Common\SensorInterface on a KRC4 or KRC5, under the name that
    the ETHERNET object of the RSI context has.

    Args:
        config: Such as from `standard_config`.
        generation: KRC2, KRC4 or KRC5; a KRC2 wants a protocol and a unit too.
    """
    old = generation == "KRC2"
    facts = {"IP_NUMBER": config.address, "PORT": str(config.port)}
    facts |= {"PROTOCOL": config.protocol} if old else {}
    facts |= {"SENTYPE": config.sentype, "ONLYSEND": str(config.only_send).upper()}
    lines = ["<ROOT>", "  <CONFIG>"]
    lines += [f"    <{name}>{escape(text)}</{name}>" for name, text in facts.items()]
    lines += ["  </CONFIG>"]
    for way, elements in (("SEND", config.send), ("RECEIVE", config.receive)):
        lines += [f"  <{way}>", "    <ELEMENTS>"]
        lines += [f"      {_line(element, way == 'RECEIVE', old)}" for element in elements]
        lines += ["    </ELEMENTS>", f"  </{way}>"]
    return "\n".join([*lines, "</ROOT>"]) + "\n"


def _line(element: Element, receive: bool, old: bool) -> str:
    index = str(element.index) if element.index else INTERNAL
    hold = f' HOLDON="{int(element.hold)}"' * receive
    unit = ' UNIT="0"' * old
    return f'<ELEMENT TAG={quoteattr(element.tag)} TYPE="{element.kind}" INDX="{index}"{unit}{hold} />'
