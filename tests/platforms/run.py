"""Runs one packed FMU on every platform that can run here, and compares bits.

    python3 tests/platforms/run.py GELFMU ZIG [CYCLES]

Packs scenes with all libraries inside GELFMU, compiles drive.c for each platform with ZIG, and runs it: linux64 directly,
win64 under wine, aarch64-linux under qemu. Impulse and state must be equal in each of four floating-point environments and
on every platform, and the memory of a process that loads, runs and unloads the library must stay flat. A library exports the
functions of FMI 2.0 for co-simulation and nothing else. darwin64 cannot be run here. Prints what each library needs of its system. With CYCLES of load and unload, 1000 say, only a coarse scene is run.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
TARGETS = {"linux64": "x86_64-linux-gnu.2.17", "win64": "x86_64-windows-gnu", "aarch64-linux": "aarch64-linux-gnu.2.17"}
LIBRARIES = {"linux64": "BallisticGel.so", "win64": "BallisticGel.dll", "aarch64-linux": "BallisticGel.so"}
# Scene: options of `gelfmu pack`, communication step, s, and steps.
SCENES = {"sphere-block": ([], 1e-4, 12), "fbi-bb": ([], 2e-5, 4)}
COARSE = {"sphere-block": (["--set", "mesh.size=10e-3"], 1e-4, 12)}
CYCLES = 20
# Memory by which a process may grow, bytes: once, by what allocators keep, and with each cycle. A load leaves behind the queue of freed memory that the
# threads of rayon share (crossbeam-epoch), 11 kB in static variables that no unloading frees; an instance has tens of megabytes.
GROWTH = 16 << 20
GROWTH_PER_CYCLE = 64 << 10
NEWEST_GLIBC = (2, 17)
SYSTEM_DLLS = re.compile(
    r"(api-ms-win-[a-z0-9-]+|advapi32|bcrypt|bcryptprimitives|kernel32|ntdll|ole32|oleaut32|pdh|powrprof|psapi|shell32"
    r"|userenv|ws2_32|msvcrt|ucrtbase)\.dll", re.IGNORECASE)


# Functions of FMI 2.0 for co-simulation (sections 2.1 and 4.2 of the standard).
TYPES = ["Real", "Integer", "Boolean", "String"]
INTERFACE = {
    "fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2SetDebugLogging", "fmi2Instantiate", "fmi2FreeInstance", "fmi2SetupExperiment",
    "fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2Reset", "fmi2GetFMUstate", "fmi2SetFMUstate",
    "fmi2FreeFMUstate", "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative", "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives", "fmi2DoStep", "fmi2CancelStep",
    "fmi2GetStatus", *(f"fmi2Get{kind}" for kind in TYPES), *(f"fmi2Set{kind}" for kind in TYPES),
    *(f"fmi2Get{kind}Status" for kind in TYPES),
}


def output(*command, **options):
    """Standard output of a command; its failure ends the run."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=1200, **options)
    if done.returncode != 0:
        raise SystemExit(f"{command[0]} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def runner(platform, folder):
    """Command before the driver on this machine, and its environment; None where it cannot run."""
    if platform == "linux64":
        return [], {}
    if platform == "win64" and shutil.which("wine"):
        return ["wine"], {"WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}
    root = Path("/usr/aarch64-linux-gnu")
    if platform == "aarch64-linux" and shutil.which("qemu-aarch64") and (root / "lib").exists():
        return ["qemu-aarch64", "-L", str(root)], {}
    return None


def compiled(zig, platform, folder):
    """The driver of a platform."""
    place = folder / platform
    place.mkdir()
    driver = place / ("drive.exe" if platform == "win64" else "drive")
    output(zig, "cc", "-target", TARGETS[platform], "-O1", "-frounding-math", HERE / "drive.c", "-o", driver,
           *([] if platform == "win64" else ["-ldl", "-lm"]))
    if platform == "win64":
        output(zig, "cc", "-target", TARGETS[platform], "-shared", HERE / "bcryptprimitives.c", "-ladvapi32",
               "-o", place / "bcryptprimitives.dll")
    return driver


def uri(platform, folder):
    """URI of a folder as an importer on the platform gives it; wine has the root of this system as drive Z."""
    return f"file:///Z:{folder}" if platform == "win64" else f"file://{folder}"


def packed(gelfmu, scene, options, folder):
    """Unpacks a new FMU of a scene; returns its folder, GUID and value references."""
    archive, unpacked = folder / f"{scene}.fmu", folder / scene
    output(gelfmu, "pack", scene, *options, "--out", archive)
    print(f"{archive.name}: {archive.stat().st_size} bytes")
    with zipfile.ZipFile(archive) as zipped:
        zipped.extractall(unpacked)
    root = xml.etree.ElementTree.parse(unpacked / "modelDescription.xml").getroot()
    references = {variable.get("name"): variable.get("valueReference") for variable in root.iter("ScalarVariable")}
    return unpacked, root.get("guid"), references


def exported(library):
    """Names that a library exports, by binutils."""
    if library.suffix == ".dll":
        table = output("objdump", "-p", library).split("[Ordinal/Name Pointer] Table", 1)[1].split("\n\n", 1)[0]
        return set(re.findall(r"^\s*\[ *\d+\].* (\S+)$", table, re.MULTILINE))
    symbols = [line.split() for line in output("readelf", "--dyn-syms", "--wide", library).splitlines()]
    return {symbol[7].split("@")[0] for symbol in symbols if len(symbol) > 7 and symbol[6].isdigit()}


def check_exports(library):
    """Refuses a library that exports anything but its interface, or not all of it."""
    names = exported(library)
    if names != INTERFACE:
        more, missing = sorted(names - INTERFACE), sorted(INTERFACE - names)
        raise SystemExit(f"{library}: found {len(more)} exports beyond the interface, {more[:9]}, and without {missing}, expected the "
                         "functions of FMI 2.0 for co-simulation alone: see the list of exports in build/platforms.sh")


def check_needs(library):
    """Prints what a library needs, and refuses what old systems lack."""
    if library.suffix == ".dll":
        imports = output("objdump", "-p", library)
        # Windows has 1088 indices of thread-local storage, and unloading gives none back: some hundred loads would end the process.
        if re.search(r"\bTlsAlloc\b", imports):
            raise SystemExit(f"{library}: found an import of TlsAlloc, expected native thread-local storage")
        needs = re.findall(r"DLL Name: (\S+)", imports)
        strange = [name for name in needs if not SYSTEM_DLLS.fullmatch(name)]
        if strange:
            raise SystemExit(f"{library}: found imports of {strange}, expected only those of the system")
        print(f"{library.parent.name}: {library.stat().st_size} bytes, needs {', '.join(sorted(needs))}")
        return
    versions = {tuple(map(int, found.split("."))) for found in re.findall(r"GLIBC_([0-9.]+)\0", library.read_bytes().decode("latin-1"))}
    newest = max(versions)
    if newest > NEWEST_GLIBC:
        raise SystemExit(f"{library}: found GLIBC_{'.'.join(map(str, newest))}, expected at most 2.17")
    print(f"{library.parent.name}: {library.stat().st_size} bytes, needs glibc {'.'.join(map(str, newest))}")


def check_memory(scene, platform, text, cycles):
    """Refuses a process that grew with the cycles of load and unload."""
    early, late = map(int, re.search(r"memory (\d+) bytes after \d+ cycles, (\d+) after all", text).groups())
    most = GROWTH + cycles * GROWTH_PER_CYCLE
    if late - early > most:
        raise SystemExit(f"{scene} on {platform}: found {late} bytes after {early}, expected at most {most} more")


def main():
    gelfmu, zig = (Path(argument).resolve() for argument in sys.argv[1:3])
    scenes, cycles = (COARSE, int(sys.argv[3])) if len(sys.argv) > 3 else (SCENES, CYCLES)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["HOME"] = name
        drivers, passed = {}, 0
        for scene, (options, step, steps) in scenes.items():
            unpacked, guid, references = packed(gelfmu, scene, options, folder)
            seen = {}
            for platform in TARGETS:
                library = unpacked / "binaries" / platform / LIBRARIES[platform]
                if not library.exists():
                    print(f"{platform}: skipped, not in the archive")
                    continue
                if platform not in drivers:
                    check_exports(library)
                    check_needs(library)
                    drivers[platform] = compiled(zig, platform, folder)
                found = runner(platform, folder)
                if found is None:
                    print(f"{platform}: skipped, cannot be run here")
                    continue
                command, environment = found
                seen[platform] = output(
                    *command, drivers[platform], library, guid, uri(platform, unpacked / "resources"), step, steps, cycles,
                    references["threads"], references["contact.total_impulse[3]"], env=os.environ | environment)
            passed += len(seen)
            for platform, text in seen.items():
                print(f"{scene} on {platform}:\n{text.strip()}", flush=True)
                check_memory(scene, platform, text, cycles)
            results = {text.split("memory ")[0] for text in seen.values()}
            runs = [line.split(" impulse ")[1] for line in next(iter(results)).splitlines() if " impulse " in line]
            if len(results) != 1 or len(set(runs)) != 1 or len(runs) != 4:
                raise SystemExit(f"{scene}: the bits differ between platforms or floating-point environments")
        print(f"{passed} passed, 0 failed")


if __name__ == "__main__":
    main()
