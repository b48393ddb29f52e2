"""Quoting: any text comes back out of the language it is quoted for, and stays inside its literal."""

import ast
import json
import re
import tomllib
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import pytest
from ruamel.yaml import YAML

from exidyn.quoting import (
    CONTROL,
    KRL_LINE,
    KRL_NAME,
    cpp_comment,
    cpp_name,
    cpp_text,
    double_quoted,
    hash_comment,
    json_text,
    krl_comment,
    krl_name,
    one_line,
    python_text,
    xml_attribute,
    xml_content,
    xml_document,
)

from .parts.small.hostile_names import HALVES, NAMES

EVERY = (*NAMES, *HALVES)


def whole(text):
    """The text with the replacement character for halves of pairs."""
    return "".join("\ufffd" if "\ud800" <= c <= "\udfff" else c for c in text)


@pytest.mark.parametrize("text", EVERY)
def test_python_evaluates_to_the_text(text):
    assert ast.literal_eval(python_text(text)) == text
    assert python_text(text).isascii()
    assert "\n" not in python_text(text)


@pytest.mark.parametrize("text", EVERY)
def test_toml_and_yaml_read_the_text(text):
    quoted = double_quoted(text)
    assert tomllib.loads(f"name = {quoted}\n") == {"name": whole(text)}
    assert YAML(typ="safe", pure=True).load(f"name: {quoted}\n") == {"name": whole(text)}


@pytest.mark.parametrize("text", EVERY)
def test_json_reads_the_text_and_holds_nothing_that_a_terminal_obeys(text):
    written = json_text({text: [text]})
    assert json.loads(written) == {text: [text]}
    assert not CONTROL.search(written.replace("\n", ""))


@pytest.mark.parametrize("text", EVERY)
def test_xml_reads_the_text_with_controls_as_their_codes(text):
    root = Element("root", name=text)
    SubElement(root, "leaf").text = text
    read = ElementTree.fromstring(xml_document(root).encode())
    assert read.get("name") == one_line(text)
    assert (read.findtext("leaf") or "") == one_line(text)
    for quote in "\"'":
        element = f"<a b={xml_attribute(text, quote)}>{xml_content(text)}</a>"
        read = ElementTree.fromstring(element)
        assert read.get("b") == one_line(text)
        assert (read.text or "") == one_line(text)


@pytest.mark.parametrize("text", EVERY)
def test_comments_stay_on_their_line(text):
    for comment, start in ((hash_comment(text), "# "), (krl_comment(text), ";")):
        assert comment.startswith(start)
        assert len(comment.splitlines()) == 1
        assert not CONTROL.search(comment)
    assert krl_comment(text).isascii()
    assert len(krl_comment(text)) <= KRL_LINE


@pytest.mark.parametrize("text", EVERY)
def test_krl_names_are_names(text):
    name = krl_name(text)
    assert name.isascii()
    assert name.isidentifier()
    assert len(name) <= KRL_NAME


def test_different_names_stay_different_on_one_line():
    assert len({one_line(text) for text in EVERY}) == len(EVERY)


@pytest.mark.parametrize("text", EVERY)
def test_cpp_texts_names_and_comments_are_plain_ascii_on_one_line(text):
    quoted = cpp_text(text)
    assert quoted.isascii()
    assert quoted[0] == quoted[-1] == '"'
    inside = re.sub(r"\\[0-7]{3}", "", quoted[1:-1])
    assert not re.search(r'["\\\n?]', inside)
    octal = re.sub(r"\\([0-7]{3})", lambda match: chr(int(match[1], 8)), quoted[1:-1])
    assert octal.encode("latin-1") == text.encode("utf-8", "replace")
    assert re.fullmatch(r"exidyn(_[A-Za-z0-9]+)*", cpp_name(text))
    comment = cpp_comment(text)
    assert comment.isascii()
    assert comment.startswith("// ")
    assert "\n" not in comment
    assert "\\" not in comment
