"""Clients of Grbl that are not ours, without their windows.

usage: grbl_clients.py bcnc socket://127.0.0.1:PORT JOB.nc
       grbl_clients.py pygrbl DEVICE JOB.nc

Each runs its job with a hold in it and prints what it has seen, one JSON object at the end.
"""
import builtins
import json
import os
import sys
import threading
import time

SEEN = {}


def until(what, limit, true, meanwhile=lambda: None):
    """Waits for something; the process ends when it does not come."""
    end = time.time() + limit
    while not true():
        meanwhile()
        if time.time() > end:
            print(f"never: {what}", file=sys.stderr)
            os._exit(1)
        time.sleep(0.02)


def bcnc(port, job):
    builtins._ = lambda text: text
    import bCNC

    folder = os.path.dirname(bCNC.__file__)
    for part in ("", "lib", "plugins", "controllers"):
        sys.path.append(os.path.join(folder, part))
    import Utils

    Utils.loadConfiguration(True)
    import Sender
    from CNC import CNC, WAIT

    class Headless(Sender.Sender):
        def event_generate(self, *_args, **_keys):
            pass

        def disable(self):
            pass

        def busy(self):
            pass

        def notBusy(self):
            pass

        def setStatus(self, *_args, **_keys):
            pass

    sender, errors, answers = Headless(), [], [0]

    def drain():
        while not sender.log.empty():
            kind, line = sender.log.get()
            answers[0] += kind == Sender.Sender.MSG_OK
            if kind == Sender.Sender.MSG_ERROR:
                errors.append(str(line))

    def state():
        return CNC.vars["state"]

    def seen(what, limit, true):
        until(f"{what}; it is {state()}", limit, true, drain)

    sender.open(port, 115200)
    seen("Idle", 20, lambda: state() == "Idle")
    sender.viewSettings()
    seen("$132", 10, lambda: CNC.vars.get("grbl_132"))
    SEEN["travel"] = float(CNC.vars["grbl_130"])
    sender.mcontrol.jog("X30")
    seen("Jog", 10, lambda: state() == "Jog")
    seen("Idle behind the jog", 20, lambda: state() == "Idle")
    SEEN["jogged"] = CNC.vars["mx"]
    sender._wcsSet("0", "0", "0")
    seen("the zero", 10, lambda: CNC.vars["wx"] == 0.0)
    with open(job, encoding="ascii") as file:
        lines = file.read().splitlines()
    sender.initRun()
    sender._gcount, sender._runLines, count = 0, sys.maxsize, 1
    for line in CNC.compile(lines):
        if line is not None:
            sender.queue.put(line + "\n" if isinstance(line, str) else line)
            count += 1
    sender._runLines = count
    sender.queue.put((WAIT,))
    seen("Run", 20, lambda: state() == "Run")
    sender.pause()
    seen("Hold", 10, lambda: state().startswith("Hold"))
    sender.pause()
    seen("Run again", 20, lambda: state() == "Run")
    CNC.vars["_OvFeed"], CNC.vars["_OvChanged"] = 130, True
    seen("the override", 20, lambda: CNC.vars["OvFeed"] == 130)
    seen("the end", 120, lambda: sender._gcount >= sender._runLines)
    seen("Idle at the end", 20, lambda: state() == "Idle")
    SEEN.update(lines=count, end=[CNC.vars["wx"], CNC.vars["wy"]], errors=errors)
    sender.runEnded()
    sender.thread = None
    time.sleep(0.3)


def pygrbl(port, job):
    from pygrbl_streamer import GrblStreamer

    streamer, events = GrblStreamer(port), []
    streamer.error_callback = lambda line: events.append(("error", line))
    streamer.alarm_callback = lambda line: events.append(("alarm", line))
    streamer.disconnect_callback = lambda why: events.append(("gone", str(why)))
    streamer.connect()
    streamer.send_file(job)
    SEEN["first"] = streamer.state.name
    again = threading.Thread(target=lambda: streamer.send_file(job))
    again.start()
    time.sleep(1.5)
    streamer.pause()
    time.sleep(0.7)
    SEEN["paused"] = streamer.state.name
    streamer.resume()
    time.sleep(0.5)
    streamer.stop()
    again.join(20)
    SEEN["ended"] = not again.is_alive()
    SEEN["events"] = events
    streamer.disconnect()


if __name__ == "__main__":
    {"bcnc": bcnc, "pygrbl": pygrbl}[sys.argv[1]](*sys.argv[2:])
    print(json.dumps(SEEN))
    sys.stdout.flush()
    os._exit(0)
