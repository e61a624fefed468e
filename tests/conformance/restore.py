"""Run by test_state.py in a process of its own: restore a state, go on, print every bit."""

import json
import sys

import bits
from own_body import Gel

folder, file, step = sys.argv[1], sys.argv[2], float(sys.argv[3])
gel = Gel(folder)
with open(file, "rb") as source:
    pointer = gel.fmu.deSerializeFMUstate(source.read())
gel.fmu.setFMUState(pointer)
gel.fmu.freeFMUState(pointer)
bits.run(gel, 20, 40, step)
print(json.dumps({"reals": bits.reals(gel), "state": bits.state(gel).hex()}))
gel.free()
