"""A simulator of RSI that is no controller: it waits for answers, and stamps with how many it was given.

Its axes are where they are corrected to, and are sent with as many decimals as a number needs. Unanswered,
it sends the same again. Prints `ready`, and at its end how many answers it was given, of how many telegrams.
Ends on the Stop channel or at the end of standard input.
"""

import argparse
import json
import select
import socket
import sys
import time
import xml.etree.ElementTree as ElementTree

AXES = ("A1", "A2", "A3", "A4", "A5", "A6")


def telegram(position, late, count):
    axes = " ".join(f'{axis}="{value}"' for axis, value in zip(AXES, position, strict=True))
    return f'<Rob TYPE="KUKA"><AIPos {axes}/><Delay D="{late}"/><IPOC>{count}</IPOC></Rob>'.encode()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", required=True, help="RSI_EthernetConfig.xml")
    parser.add_argument("--start", default="0,-90,90,0,90,0", help="pose of the axes [deg]")
    parser.add_argument(
        "--pause", type=float, default=0.002, help="between an answer and the next telegram [s]"
    )
    parser.add_argument("--patience", type=float, default=1.0, help="how long an answer is waited for [s]")
    given = parser.parse_args()
    root = ElementTree.parse(given.config).getroot()
    to = (root.findtext("CONFIG/IP_NUMBER"), int(root.findtext("CONFIG/PORT")))
    start = [float(part) for part in given.start.split(",")]
    position, late, count, sent = start, 0, 0, 0
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.bind(("127.0.0.1", 0))
    link.settimeout(given.patience)
    print("ready", *link.getsockname(), flush=True)
    while not select.select([sys.stdin], [], [], 0)[0]:
        sent += 1
        try:
            link.sendto(telegram(position, late, count), to)
            answer = ElementTree.fromstring(link.recv(65535))
        except OSError:
            late += 1
            continue
        corrections = answer.find("AK").attrib
        position = [begin + float(corrections[axis]) for begin, axis in zip(start, AXES, strict=True)]
        count += 1
        if answer.findtext("Stop") == "1":
            break
        time.sleep(given.pause)
    print(json.dumps({"answered": count, "sent": sent}), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
