"""The object dictionary of a drive that is not ours: ROS-Industrial's fake CiA 402 slave.

What is there, of which type, access and default, is that of `cia402_slave.eds` of ros2_canopen (package
canopen_fake_slaves, Apache-2.0); the file itself is not here. It has no current, no torque, no rated values,
no 0x6007, no 0x1003, 0x1006 and 0x6066, and its device name is an object without a value.
"""

import canopen
from canopen import objectdictionary as dictionary

TYPES = {
    "i8": dictionary.INTEGER8,
    "i16": dictionary.INTEGER16,
    "i32": dictionary.INTEGER32,
    "u8": dictionary.UNSIGNED8,
    "u16": dictionary.UNSIGNED16,
    "u32": dictionary.UNSIGNED32,
    "text": dictionary.VISIBLE_STRING,
    "octets": dictionary.OCTET_STRING,
}

VALUES = """
1000 u32 const 0xFFFF0192
1001 u8 ro
1005 u32 rw 0x80
1008 text const
1009 text const
100A text const
100C u16 rw 0
100D u8 rw 0
1014 u32 rw $80
1015 u16 rw 0
1017 u16 rw 0
6040 u16 rww
6041 u16 ro
605A i16 rw 2
605B i16 ro 0
605C i16 ro 1
605D i16 rw 1
605E i16 ro 2
6060 i8 rww 0
6061 i8 ro
6062 i32 ro
6063 i32 ro
6064 i32 ro
6065 u32 rw
6067 u32 rw 0xFFFFFFFF
6068 u16 rw 0
606A i16 rw
606C i32 ro
607A i32 rww 0
607C i32 rw 0
6081 u32 rw
6082 u32 rw 0
6083 u32 rw
6084 u32 rw
6085 u32 rw
6098 i8 rw 0
609A u32 rw
60B0 i32 rw 0
60B1 i32 rw 0
60F2 u16 rw 0
60FD u32 ro
60FF i32 rw 0
6502 u32 ro 0xA5
67FF u32 ro 0x00040192
"""
"""Index, type, access and default of objects with one value; $ is the node's number and."""

RECORDS = """
1010 u8 ro 7, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw
1011 u8 ro 7, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw, u32 rw
1016 u8 ro 1, u32 rw 0
1018 u8 ro 4, u32 ro 0x555, u32 ro 1, u32 ro 0, u32 ro 0
1023 u8 ro 3, octets rw, u8 ro, octets ro
1029 u8 ro 2, u8 rw 0, u8 rw 1
1400 u8 ro 2, u32 rw $40000200, u8 rw 0xFF
1401 u8 ro 2, u32 rw $40000300, u8 rw 0xFF
1402 u8 ro 2, u32 rw $40000400, u8 rw 0xFF
1403 u8 ro 2, u32 rw $C0000500, u8 rw 0xFE
1600 u8 rw 1, u32 rw 0x60400010, u32 rw 0, u32 rw 0
1601 u8 rw 2, u32 rw 0x60400010, u32 rw 0x60600008, u32 rw 0
1602 u8 rw 2, u32 rw 0x60400010, u32 rw 0x607A0020, u32 rw 0
1603 u8 rw 2, u32 rw 0x60400010, u32 rw 0x60FF0020, u32 rw 0
1800 u8 ro 5, u32 rw $40000180, u8 rw 1, u16 rw 0, u8 ro, u16 rw 0
1801 u8 ro 5, u32 rw $40000280, u8 rw 1, u16 rw 0, u8 ro, u16 rw 0
1802 u8 ro 5, u32 rw $40000380, u8 rw 1, u16 rw 0, u8 ro, u16 rw 0
1803 u8 ro 5, u32 rw $C0000480, u8 rw 0xFE, u16 rw 0, u8 ro, u16 rw 0
1A00 u8 rw 1, u32 rw 0x60410010, u32 rw 0, u32 rw 0
1A01 u8 rw 2, u32 rw 0x60410010, u32 rw 0x60610008, u32 rw 0
1A02 u8 rw 2, u32 rw 0x60410010, u32 rw 0x60640020, u32 rw 0
1A03 u8 rw 2, u32 rw 0x60410010, u32 rw 0x606C0020, u32 rw 0
607D u8 const 2, i32 rw -2147483648, i32 rw 2147483647
608F u8 const 2, u32 rw, u32 ro 1
6099 u8 const 2, u32 rw, u32 rw
60C2 u8 const 2, u8 rw 1, i8 rw -2
"""
"""Index, then type, access and default of each sub-index from 0."""


def ros2_dictionary(number):
    """The dictionary of the node with a number."""
    made = canopen.ObjectDictionary()
    for line in VALUES.split("\n")[1:-1]:
        index, _, rest = line.partition(" ")
        made.add_object(variable(int(index, 16), 0, rest, number))
    for line in RECORDS.split("\n")[1:-1]:
        index, _, rest = line.partition(" ")
        record = dictionary.ODRecord(index, int(index, 16))
        for sub, text in enumerate(rest.split(", ")):
            record.add_member(variable(record.index, sub, text, number))
        made.add_object(record)
    return made


def variable(index, sub, text, number):
    kind, access, *default = text.split()
    one = dictionary.ODVariable(f"{index:04X}sub{sub}", index, sub)
    one.data_type, one.access_type = TYPES[kind], access
    if default:
        own = default[0].startswith("$")
        one.default = int(default[0][1:], 16) + number if own else int(default[0], 0)
    return one
