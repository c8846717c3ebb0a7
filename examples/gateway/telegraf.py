#!/usr/bin/env python3
"""Makes a Telegraf configuration (inputs.modbus) of what a gateway describes:

    pasapas gateway examples/gateway/hall.toml --describe | examples/gateway/telegraf.py > telegraf.conf

Telegraf is not in Debian: what this writes is checked by the rules of that plugin's source, and read by another
program in the tests; Telegraf itself was not run.
"""
import csv
import sys

TABLES = {
    "coil": "coils",
    "discrete input": "discrete_inputs",
    "holding register": "holding_registers",
    "input register": "input_registers",
}


def field(row, taken):
    """A value as a line of the configuration; a name twice in a table is refused there."""
    name, first, scale = row["name"], int(row["address"]), float(row["scale"])
    if name in taken:
        name = "{}_{}".format(name, first)
    taken.add(name)
    if row["kind"] == "bit":
        return '    {{ name = "{}", address = [{}] }},'.format(name, first)
    wide = row["kind"] == "int32"
    # An integer stays one there, with its fraction cut off; FIXED is a number with a fraction.
    kind = "UINT16" if not wide else "INT32" if scale == 1 else "FIXED"
    return '    {{ name = "{}", byte_order = "{}", data_type = "{}", scale = {}, address = {} }},'.format(
        name, "CDAB" if wide else "AB", kind, scale, [first, first + 1] if wide else [first])


def main():
    boards = {}
    for row in csv.DictReader(sys.stdin):
        boards.setdefault((row["board"], row["unit"]), []).append(row)
    for (board, unit), rows in boards.items():
        print('[[inputs.modbus]]\n  name = "{}"\n  slave_id = {}'.format(board, unit))
        print('  controller = "tcp://127.0.0.1:1502"')
        for table, key in TABLES.items():
            taken = set()
            print("  {} = [".format(key))
            for row in rows:
                if row["table"] == table:
                    print(field(row, taken))
            print("  ]")


main()
