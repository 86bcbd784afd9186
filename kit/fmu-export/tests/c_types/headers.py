"""Sizes, alignments, offsets and values of the C types in the FMI standard's headers, as a C compiler has them; writes headers.txt beside
this file.

    python headers.py            # with FMPy installed, whose package holds the headers
    python headers.py --print    # only print

The file is that of a 64-bit platform; it changes only where the standard does. Lines: `type NAME SIZE ALIGNMENT`, `field TYPE.NAME OFFSET`,
`value NAME VALUE`.
"""

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

FILE = Path(__file__).with_name("headers.txt")
INCLUDED = ["fmi2Functions.h", "fmi3Functions.h"]
TYPES = """
    fmi2Component fmi2ComponentEnvironment fmi2FMUstate fmi2ValueReference fmi2Real fmi2Integer fmi2Boolean fmi2String fmi2Byte fmi2Status
    fmi2Type fmi2StatusKind fmi2CallbackLogger fmi2CallbackAllocateMemory fmi2CallbackFreeMemory fmi2StepFinished fmi2CallbackFunctions
    fmi2EventInfo
    fmi3Instance fmi3InstanceEnvironment fmi3FMUState fmi3ValueReference fmi3Boolean fmi3Clock fmi3String fmi3Byte fmi3Binary fmi3Status
    fmi3DependencyKind fmi3LogMessageCallback fmi3IntermediateUpdateCallback fmi3ClockUpdateCallback fmi3LockPreemptionCallback
    fmi3UnlockPreemptionCallback
""".split()
FIELDS = {
    "fmi2CallbackFunctions": "logger allocateMemory freeMemory stepFinished componentEnvironment".split(),
    "fmi2EventInfo": """newDiscreteStatesNeeded terminateSimulation nominalsOfContinuousStatesChanged valuesOfContinuousStatesChanged
        nextEventTimeDefined nextEventTime""".split(),
}
VALUES = """
    fmi2OK fmi2Warning fmi2Discard fmi2Error fmi2Fatal fmi2Pending fmi2ModelExchange fmi2CoSimulation
    fmi2DoStepStatus fmi2PendingStatus fmi2LastSuccessfulTime fmi2Terminated
    fmi3OK fmi3Warning fmi3Discard fmi3Error fmi3Fatal fmi3Dependent
""".split()


def program():
    """A C program that prints the lines."""
    printed = [f'"type {name} %zu %zu\\n", sizeof({name}), _Alignof({name})' for name in TYPES]
    printed += [f'"field {of}.{name} %zu\\n", offsetof({of}, {name})' for of, names in FIELDS.items() for name in names]
    printed += [f'"value {name} %d\\n", (int){name}' for name in VALUES]
    head = "".join(f"#include <{name}>\n" for name in ["stddef.h", "stdio.h", *INCLUDED])
    return head + "int main(void) {\n" + "".join(f"    printf({call});\n" for call in printed) + "}\n"


def lines(compiler="cc"):
    """What the program prints, compiled against FMPy's copy of the headers."""
    headers = Path(importlib.util.find_spec("fmpy").origin).with_name("c-code")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "types.c")
        source.write_text(program())
        built = Path(folder, "types")
        subprocess.run([compiler, "-std=c11", "-I", headers, source, "-o", built], check=True)
        return subprocess.run([built], check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    if "--print" in sys.argv:
        print(lines(), end="")
    else:
        FILE.write_text(lines())
