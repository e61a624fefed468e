"""Everything that can be compared bit by bit."""


def reals(gel):
    """Every Real of the instance, as hexadecimal text."""
    references = [v.valueReference for v in gel.description.modelVariables if v.type == "Real"]
    return [value.hex() for value in gel.fmu.getReal(references)]


def state(gel):
    """The serialised state."""
    pointer = gel.fmu.getFMUState()
    data = gel.fmu.serializeFMUstate(pointer)
    gel.fmu.freeFMUState(pointer)
    return bytes(data)


def digest(gel):
    """The hash of the simulation in the header of the serialised state."""
    return state(gel)[12:28].hex()


def run(gel, first, last, step):
    """Steps number `first` to `last` - 1."""
    for k in range(first, last):
        gel.fmu.doStep(k * step, step)
