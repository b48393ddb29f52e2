"""Telegrams, read and answered, whatever the bytes."""

import random
import xml.etree.ElementTree as ElementTree

import pytest

from exidyn.drivers.kuka_rsi.config import AXES, Element, standard_config
from exidyn.drivers.kuka_rsi.telegram import LEARN, LONGEST, Answer, TelegramReader, decimals

from ...parts.controllers.rsi_controller import START, telegram

NAMES = [f"{element}.{axis}" for element in ("AIPos", "MACur") for axis in AXES] + ["Delay.D"]
CURRENT = (-1.924, 0.734, 2.369, 0.032, 0.239, -0.066)


def read(data, names=NAMES):
    return TelegramReader(names).read(data)


def test_numbers_come_in_the_order_asked_for_and_the_stamp_as_it_was():
    found = read(telegram(4208163634, current=CURRENT, delay=3))
    assert found.numbers == (*START, *CURRENT, 3.0)
    assert (found.stamp, found.time) == (b"4208163634", 4208163634)


def test_any_order_nesting_and_spaces_and_names_that_are_no_xml():
    data = b"""<Rob TYPE='KUKA'> <Dat TaskType="b"><IPOC>0012</IPOC><Out 01="1" 02="0" />
    <DiL> 7 </DiL><AIPos A2 = "-1e1" A1="+2."></AIPos></Dat></Rob>"""
    assert read(data, ["AIPos.A1", "DiL", "Out.02", "AIPos.A2"]) == (b"0012", 12, (2.0, 7.0, 0.0, -10.0))


def test_later_telegrams_may_have_another_form():
    reader = TelegramReader(NAMES)
    other = telegram(5, more="<RSol X='1'/>")
    for data in [telegram(1)] + [other] * (LEARN + 5) + [telegram(9)]:
        assert reader.read(data).numbers[:6] == START


@pytest.mark.parametrize(
    "wrong",
    [
        b"",
        b'<Rob Type="KUKA"></Rob>',
        telegram(1).replace(b"10.0000", b"nan"),
        telegram(1).replace(b"10.0000", b"inf"),
        telegram(1).replace(b"10.0000", b"1e999"),
        telegram(1).replace(b"10.0000", b"1.2.3"),
        telegram(1).replace(b"10.0000", b""),
        telegram(1).replace(b"10.0000", "١".encode()),
        telegram(1).replace(b"AIPos", b"AIPot"),
        telegram(123)[: telegram(123).index(b"3</IPOC>")],
        b"x" + telegram(1),
        telegram(1).replace(b"</Rob>", b"<IPOC>2</IPOC></Rob>"),
        telegram(1).replace(b"<IPOC>1<", b"<IPOC>-1<"),
        telegram(1).replace(b"<IPOC>1<", b"<IPOC>1.5<"),
        telegram(1).replace(b"<IPOC>1<", b"<IPOC>" + b"1" * 5000 + b"<"),
        telegram(1, more=" " * LONGEST),
    ],
)
def test_what_is_no_telegram_is_none(wrong):
    assert read(wrong) is None
    reader = TelegramReader(NAMES)
    reader.read(telegram(1))
    assert reader.read(wrong) is None


def test_what_is_missing_is_named():
    data = telegram(1).replace(b"MACur", b"MECur")
    assert TelegramReader(NAMES).missing(data) == [f"MACur.{axis}" for axis in AXES]


def mutated(rng, data):
    """Some bytes changed, cut, doubled, moved or put in."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        place, length = rng.randrange(len(data) + 1), rng.randint(1, 20)
        kind = rng.randrange(5)
        if kind == 0:
            data[place : place + 1] = bytes([rng.randrange(256)])
        elif kind == 1:
            del data[place : place + length]
        elif kind == 2:
            data[place:place] = data[place : place + length]
        elif kind == 3:
            data[place:place] = rng.randbytes(length)
        else:
            data[place:place] = rng.choice([b'"', b"<", b">", b"/>", b"=", b" ", b"e", b"9" * 400, b"\x00"])
    return bytes(data)


def test_no_bytes_break_the_reader():
    rng = random.Random(4)
    fast = TelegramReader(NAMES)
    fast.read(telegram(1))
    whole = 0
    for number in range(6000):
        data = mutated(rng, telegram(number)) if number % 3 else rng.randbytes(rng.randrange(2000))
        slowly, quickly = read(data), fast.read(data)
        assert slowly == quickly
        if slowly is not None:
            whole += 1
            assert len(slowly.numbers) == len(NAMES)
            assert all(abs(number) < float("inf") for number in slowly.numbers)
        fast.missing(data), decimals(data, "AIPos")
    assert 200 < whole < 3000  # some were only changed where nobody looks, or to other numbers


def test_long_lists_of_nearly_elements_are_read_in_time():
    # would take minutes if the pattern went back over them again and again
    for part in (b"<a ", b'<a b="', b"<a b", b" ", b"<", b'a="b" ', b"<a" + b" " * 4000 + b"b"):
        assert read((b"<" + part * LONGEST)[:LONGEST]) is None


def test_the_answer_is_what_the_controller_expects():
    config = standard_config("127.0.0.1", sentype="Own %d")
    others = (Element("DEF_EStr", "STRING"), Element("RKorr.X", "DOUBLE", 9), Element("Out.1", "BOOL", 10))
    answer = Answer(config.sentype, (*others, *config.receive), [f"AK.{axis}" for axis in AXES], "Stop")
    head = answer.head([1.5, -1e-7, 0.1234567, 0.0, -4.999999, 1e-3])
    text = answer.complete(head, b"0012").decode()
    assert text == (
        '<Sen Type="Own %d"><EStr></EStr><RKorr X="0.0000"/><Out 1="0"/><AK A1="1.500000" A2="-0.000000" '
        'A3="0.123457" A4="0.000000" A5="-4.999999" A6="0.001000"/><Stop>0</Stop><IPOC>0012</IPOC></Sen>'
    )
    stopping = answer.complete(answer.head([0.0] * 6, stop=True), b"1")
    assert b"<Stop>1</Stop>" in stopping
    assert ElementTree.fromstring(answer.complete(answer.head([0.0] * 6), b"1").replace(b"Out 1", b"Out o1"))


def test_joints_without_a_channel_of_their_own_leave_the_others_at_zero():
    answer = Answer("ImFree", standard_config("127.0.0.1").receive, ["AK.A1", "AK.A6"])
    text = answer.complete(answer.head([1.0, 2.0]), b"1").decode()
    assert '<AK A1="1.000000" A2="0.0000" A3="0.0000" A4="0.0000" A5="0.0000" A6="2.000000"/>' in text


def test_decimals_of_positions():
    assert decimals(telegram(1), "AIPos") == 4
    assert decimals(b'<AIPos A1="1.0" A2="2"/>', "AIPos") == 1
    assert decimals(b"", "AIPos") == 0
