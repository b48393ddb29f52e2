"""RSI_EthernetConfig.xml, read and written."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from exidyn.drivers.errors import BadSettings
from exidyn.drivers.kuka_rsi.config import Element, config_text, read_config, standard_config
from exidyn.drivers.kuka_rsi.settings import RsiSettings, config_of, layout_of
from exidyn.drivers.kuka_rsi.telegram import Answer
from exidyn.drivers.settings import read_settings
from exidyn.quoting import one_line

from ...parts.controllers.rsi_controller import config_file, driver
from ...parts.small.hostile_names import NAMES

INDUSTRIAL = """<ROOT><CONFIG><IP_NUMBER>192.168.1.25</IP_NUMBER> <!-- of the host -->
<PORT> 59152 </PORT><SENTYPE>Sensor</SENTYPE></CONFIG>
<SEND><ELEMENTS>
 <ELEMENT TAG="DEF_AIPos" TYPE="DOUBLE" INDX="INTERNAL" UNIT="0" />
 <ELEMENT TAG="GearTorque.A1" TYPE="DOUBLE" INDX="1" /><ELEMENT TAG="DiL" TYPE="LONG" INDX="9" />
</ELEMENTS></SEND>
<RECEIVE><ELEMENTS>
 <ELEMENT TAG="DEF_EStr" TYPE="STRING" INDX="INTERNAL" />
 <ELEMENT TAG="RKorr.X" TYPE="DOUBLE" INDX="9" HOLDON="1" />
 <ELEMENT TAG="AKorr.A1" TYPE="DOUBLE" INDX="1" HOLDON="1" />
 <ELEMENT TAG="AKorr.A2" TYPE="DOUBLE" INDX="2" HOLDON="1" />
 <ELEMENT TAG="Out.01" TYPE="BOOL" INDX="7" HOLDON="1" />
</ELEMENTS></RECEIVE></ROOT>"""


def settings(**given):
    return read_settings(RsiSettings, {"controller": "127.0.0.1"} | given, 2, "driver kuka_rsi")


@pytest.mark.parametrize("torque", [True, False])
def test_what_is_written_is_read_again(tmp_path, torque):
    path = tmp_path / "config.xml"
    config = standard_config("10.1.2.3", 49001, "A&B", only_send=True, torque=torque, stop=torque)
    path.write_text(config_text(config))
    assert read_config(path) == config


@pytest.mark.parametrize("name", NAMES)
def test_hostile_names_stay_inside_their_element(tmp_path, name):
    path, plain = tmp_path / "config.xml", standard_config("10.1.2.3", 49001)
    path.write_text(config_text(replace(plain, sentype=f"A{name}", address=f"B{name}")))
    read = read_config(path)
    assert (read.sentype, read.address) == (one_line(f"A{name}").strip(), one_line(f"B{name}").strip())
    assert replace(read, sentype=plain.sentype, address=plain.address) == plain
    answer = Answer(f"A{name}", plain.receive, ["AK.A1"]).complete(b"", b"7")
    head = Answer(f"A{name}", plain.receive, ["AK.A1"]).head([0.0])
    telegram = ElementTree.fromstring(head + answer)
    assert telegram.get("Type") == one_line(f"A{name}")
    assert telegram.findtext("IPOC") == "7"


def test_names_types_and_channels_of_other_peoples_files(tmp_path):
    path = tmp_path / "config.xml"
    path.write_text(INDUSTRIAL)
    config = read_config(path)
    assert (config.address, config.port, config.sentype) == ("192.168.1.25", 59152, "Sensor")
    assert not config.only_send
    assert config.send[1] == Element("GearTorque.A1", "DOUBLE", 1)
    assert config.sends("AIPos.A6")
    assert not config.sends("MACur.A1")
    layout = layout_of(config, settings(config=str(path)), 2)
    assert layout.corrections == ("AKorr.A1", "AKorr.A2")
    assert layout.elements == ("AIPos",)  # torques of one axis alone are none of the arm
    assert layout.names == ("AIPos.A1", "AIPos.A2")
    assert layout.switch == ""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<PORT> 59152 </PORT>", "", "has no CONFIG/PORT"),
        ("59152", "70000", "PORT is '70000'; valid are 1 to 65535"),
        ("59152", "x", "PORT is 'x'"),
        ("</CONFIG>", "<PROTOCOL>TCP</PROTOCOL></CONFIG>", "PROTOCOL is TCP; the driver uses UDP only"),
        ("</CONFIG>", "<ONLYSEND>maybe</ONLYSEND></CONFIG>", "ONLYSEND is 'maybe'. Valid: TRUE, FALSE"),
        ('INDX="9" />', 'INDX="65" />', "DiL: INDX is '65'; valid are 1 to 64"),
        ('TYPE="LONG"', 'TYPE="FLOAT"', "DiL has TYPE 'FLOAT'. Valid: BOOL, STRING, LONG, DOUBLE"),
        ('TAG="AKorr.A2"', 'TAG="AKorr.A1"', "RECEIVE has tag AKorr.A1 twice"),
        ('INDX="2"', 'INDX="1"', "RECEIVE has index 1 twice"),
        ('TAG="DiL"', 'TAG=".A1"', "TAG is '.A1'; expected a name, or two with a dot between"),
        ("</ROOT>", "", "is not XML"),
    ],
)  # fmt: skip
def test_what_a_controller_would_refuse_is_refused(tmp_path, old, new, message):
    path = tmp_path / "config.xml"
    assert old in INDUSTRIAL
    path.write_text(INDUSTRIAL.replace(old, new, 1))
    with pytest.raises(BadSettings, match=re.escape(message)):
        read_config(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('INDX="2" HOLDON="1"', 'INDX="2" HOLDON="0"', 'AKorr.A2 has HOLDON="0"'),
        ("AKorr.A1", "AKorr.B1", "receives no axis corrections. Set correction_tag"),
        ("RKorr.X", "AK.A1", "receives several corrections: AK, AKorr"),
        ("AKorr.A2", "AKorr.A3", "does not receive AKorr.A2 as DOUBLE"),
        ("DEF_AIPos", "DEF_ASPos", "does not send the axes' positions: add DEF_AIPos"),
    ],
)  # fmt: skip
def test_a_configuration_without_a_place_for_what_is_needed_reports_it(tmp_path, old, new, message):
    path = tmp_path / "config.xml"
    path.write_text(INDUSTRIAL.replace(old, new))
    given = settings(config=str(path))
    with pytest.raises(BadSettings, match=re.escape(message)):
        layout_of(read_config(path), given, 2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mode": "relative"}, "every lost telegram moves the arm away"),
        ({"controller": "172.31.1"}, "controller is '172.31.1', which is not an IP address"),
        ({"cycle": 0.008}, "cycle is 0.008 s; a KRC4 has 0.012 or 0.004"),
        ({"generation": "KRC2"}, "cycle is 0.004 s; a KRC2 has 0.012"),
        ({"sign": [1, 0.5]}, r"sign[1] is 0.5. Valid: 1.0, -1.0"),
        ({"config": ""}, "give config, or bind"),
        ({"port": 50000}, "port is 50000, but"),
        ({"sentype": "Other"}, "sentype is Other, but"),
        ({"config": "/nowhere.xml"}, "/nowhere.xml cannot be read: No such file"),
    ],
)  # fmt: skip
def test_settings_that_contradict_each_other_or_the_file(tmp_path, given, message):
    path = config_file(tmp_path)
    with pytest.raises(BadSettings, match=re.escape(message)):
        config_of(settings(**{"config": str(path)} | given))


def test_without_a_file_the_standard_one_is_meant():
    config = config_of(settings(bind="10.0.0.1", log_only=True, stop_tag=""))
    assert config == standard_config("10.0.0.1", 49152, "ImFree", only_send=True, stop=False)


def test_axes_of_a_palletizer_and_none_that_do_not_exist(tmp_path):
    path = config_file(tmp_path)
    assert driver(path, 4, axes="A1 A2 A3 A6")._layout.corrections == ("AK.A1", "AK.A2", "AK.A3", "AK.A6")
    for axes, joints in (("A1 A2", 3), ("A1 A1", 2), ("A1 E1", 2), ("", 7)):
        with pytest.raises(BadSettings, match="give each joint one of A1, A2, A3, A4, A5, A6"):
            driver(path, joints, axes=axes)
    with pytest.raises(BadSettings, match=r"current_unit\[0\] is percent; set i_max"):
        driver(path, current_unit="percent")
