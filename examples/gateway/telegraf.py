#!/usr/bin/env python3
"""Makes a Telegraf configuration (inputs.modbus) of what a gateway describes:

    pasapas gateway examples/gateway/hall.toml --describe | examples/gateway/telegraf.py > telegraf.conf

Telegraf is not in Debian: this was written by its manual and not run.
"""
import csv
import sys

TABLES = {"holding register": "holding_registers", "input register": "input_registers"}


def field(row):
    first, wide = int(row["address"]), row["kind"] == "int32"
    return '    {{ name = "{}", byte_order = "{}", data_type = "{}", scale = {}, address = {} }},'.format(
        row["name"],
        "CDAB" if wide else "AB",
        "INT32" if wide else "UINT16",
        float(row["scale"]),
        [first, first + 1] if wide else [first],
    )


def main():
    boards = {}
    for row in csv.DictReader(sys.stdin):
        boards.setdefault((row["board"], row["unit"]), []).append(row)
    for (board, unit), rows in boards.items():
        print('[[inputs.modbus]]\n  name = "{}"\n  slave_id = {}'.format(board, unit))
        print('  controller = "tcp://127.0.0.1:1502"')
        for table, key in TABLES.items():
            print("  {} = [".format(key))
            for row in rows:
                if row["table"] == table:
                    print(field(row))
            print("  ]")


main()
