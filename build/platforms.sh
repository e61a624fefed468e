#!/usr/bin/env bash
# The libraries of the FMU for other platforms than this one, and for older systems, into target/platforms/binaries/PLATFORM/.
#
#     build/platforms.sh [--quick] [linux64] [win64] [aarch64-linux] [darwin64]
#
# Without names all four. With --quick, for tests, into target/platforms/quick/PLATFORM/: without darwin64 if it is not named, linux64
# less and the others hardly optimized: the same bits, more slowly. With BALLISTIC_GEL_PLATFORMS=target/platforms/quick gelfmu is built with these.
# darwin64, for both processors of macOS >= 11, is linked here and was never run.
# `cargo build --release --features bundled` then puts those of the same sources into gelfmu, and `gelfmu pack` into every FMU. Needs an x86-64 Debian with Python >= 3.11 and venv; it gets its other tools itself, pinned,
# into a folder beside the registry of cargo:
# - zig as linker and C library of every target (glibc 2.17, mingw-w64, macOS), with cargo-zigbuild;
# - the sources of the standard library of exactly this rustc, from the backports of the newest Debian stable: this
#   toolchain holds only the standard library of its own platform. The package is unpacked, not installed. Where this version is
#   not served, only linux64 is made, and the last line says which platforms are missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

TOOLS="${BALLISTIC_GEL_TOOLS:-${CARGO_HOME:-$HOME/.cargo}/ballistic-gel-ci}"
OUT="$PWD/target/platforms"
RUST_VERSION=$(rustc --version | cut -d' ' -f2)
SOURCES="$TOOLS/rust-src-$RUST_VERSION"

# zig and cargo-zigbuild, in an environment of their own, kept until their versions change.
tools() {
    local venv="$TOOLS/platforms"
    if ! cmp --silent build/platforms.txt "$venv/complete"; then
        printf 'tools: getting zig and cargo-zigbuild, some 100 MB, once\n'
        rm -rf "$venv"
        python3 -m venv "$venv"
        "$venv/bin/pip" install --quiet --require-hashes --only-binary :all: --requirement build/platforms.txt
        ln -s "$("$venv/bin/python" -c 'import ziglang, pathlib; print(pathlib.Path(ziglang.__file__).parent / "zig")')" "$venv/zig"
        cp build/platforms.txt "$venv/complete"
    fi
    export CARGO_ZIGBUILD_ZIG_PATH="$venv/zig" PATH="$venv/bin:$PATH"
}

# The sources of the standard library, checked by the signed index of the suite; 1 where this version is not served, 2 on errors.
sources() {
    [[ -d "$SOURCES/library" ]] && return
    printf 'sources: getting those of the standard library of rustc %s, once\n' "$RUST_VERSION"
    local apt="$OUT/apt" base version options package sum
    rm -rf "$apt"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    base=$(apt-get indextargets --format '$(REPO_URI) $(ORIGIN) $(COMPONENT)' 'Created-By: Packages' |
        awk '$2 == "Debian" && $3 == "main" && $1 !~ /security/ { print $1; exit }')
    [[ -n "$base" ]] || { echo 'apt has no index of Debian: run apt-get update' >&2; return 2; }
    printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s stable-backports main\n' "$base" >"$apt/sources.list"
    options=(-o "Dir::Etc::SourceList=$apt/sources.list" -o Dir::Etc::SourceParts=- -o "Dir::State::Lists=$apt/lists"
        -o "Dir::Cache=$apt/cache" -o APT::Sandbox::User=root)
    apt-get "${options[@]}" --quiet update >/dev/null || return 2
    version=$(apt-cache "${options[@]}" madison rust-src | awk -v rust="$RUST_VERSION" 'index($3, rust "+") == 1 { print $3; exit }')
    [[ -n "$version" ]] || return 1
    (cd "$apt" && apt-get "${options[@]}" --quiet download "rust-src=$version" >/dev/null) || return 2
    package=("$apt"/rust-src_*.deb)
    sum=$(apt-cache "${options[@]}" show "rust-src=$version" | awk '$1 == "SHA256:" { print $2; exit }')
    printf '%s  %s\n' "$sum" "${package[0]}" | sha256sum --check --quiet || return 2
    dpkg-deb --extract "${package[0]}" "$apt/unpacked" || return 2
    rm -rf "$SOURCES"
    mkdir -p "$SOURCES"
    mv "$apt/unpacked/usr/src/rustc-$RUST_VERSION"/{COPYRIGHT,library} "$SOURCES" || return 2
    rm -rf "$apt"
}

# library PLATFORM TARGET FILE EXTENSION [OPTION...]: builds the library of one target, with the options of rustc in RUST_OPTIONS.
library() {
    local platform=$1 target=$2 file=$3 extension=$4 folder=$OUT/target/$1 cargo_home start=$SECONDS
    shift 4
    printf '%s: building; one core is busy for minutes, and nothing is printed until the end\n' "$platform"
    cargo_home=${CARGO_HOME:-$HOME/.cargo}
    # No folder of this machine in the library.
    local flags=("--remap-path-prefix=$cargo_home=/cargo" "--remap-path-prefix=$PWD=/ballistic-gel"
        "--remap-path-prefix=$SOURCES=/rust" "--remap-path-prefix=$folder=/build" ${RUST_OPTIONS:-})
    # No rlib beside it; zigbuild alone builds for two processors at once.
    local action=(rustc --crate-type cdylib)
    [[ "$target" != universal2-* ]] || action=(zigbuild)
    # A cache each: two that make the same one at once fail.
    CARGO_ZIGBUILD_CACHE_DIR="$folder/zigbuild" CARGO_ENCODED_RUSTFLAGS=$(IFS=$'\x1f' && printf '%s' "${flags[*]}") \
        cargo-zigbuild "${action[@]}" --quiet --locked --profile fmu --lib --no-default-features --target "$target" \
        --target-dir "$folder" "$@"
    mkdir -p "$binaries/$platform"
    cp "$folder/${target%.2.17}/fmu/$file" "$binaries/$platform/BallisticGel.$extension"
    printf '%s: %s bytes, in %s s\n' "$platform" "$(stat --format %s "$binaries/$platform/BallisticGel.$extension")" "$((SECONDS - start))"
}

# The same with the standard library built for the target.
library_with_std() {
    RUSTC_BOOTSTRAP=1 __CARGO_TESTS_ONLY_SRC_ROOT="$SOURCES/library" library "$@" -Z build-std=std,panic_unwind
}

platform() {
    if [[ -n "$quick" ]]; then
        export CARGO_PROFILE_FMU_CODEGEN_UNITS=16
        [[ $1 == linux64 ]] || export CARGO_PROFILE_FMU_OPT_LEVEL=1
    fi
    case $1 in
    linux64) library linux64 x86_64-unknown-linux-gnu.2.17 libballistic_gel.so so ;;
    # Without native thread-local storage each load of the library takes indices that Windows has 1088 of, and that none gives back:
    # a process that loads and frees it some hundred times would end.
    # cargo-zigbuild drops the list of exports that rustc makes, and a library without one exports every symbol of Rust.
    win64)
        { echo EXPORTS && sed -n 's/.*extern "C" fn \(fmi2[A-Za-z]*\)(.*/    \1/p' src/fmi2/abi/*.rs; } >"$OUT/win64.def"
        RUST_OPTIONS='-Zhas-thread-local=yes -Clink-arg=target/platforms/win64.def' \
            library_with_std win64 x86_64-pc-windows-gnu ballistic_gel.dll dll
        ;;
    aarch64-linux) library_with_std aarch64-linux aarch64-unknown-linux-gnu.2.17 libballistic_gel.so so ;;
    # Without a name of its own the library would name the folder that it was built in.
    darwin64)
        MACOSX_DEPLOYMENT_TARGET=11.0 RUST_OPTIONS=-Clink-arg=-Wl,-install_name,@rpath/BallisticGel.dylib \
            library_with_std darwin64 universal2-apple-darwin libballistic_gel.dylib dylib
        ;;
    *)
        printf '%s: no platform; expected linux64, win64, aarch64-linux or darwin64\n' "$1" >&2
        return 2
        ;;
    esac
}

quick= binaries="$OUT/binaries"
if [[ "${1:-}" == --quick ]]; then
    quick=yes binaries="$OUT/quick"
    shift
fi
wanted=("${@:-}")
if [[ -z "${wanted[0]}" ]]; then
    wanted=(linux64 win64 aarch64-linux)
    [[ -n "$quick" ]] || wanted+=(darwin64)
fi
mkdir -p "$OUT"
tools
names=()
missing=()
for name in "${wanted[@]}"; do
    status=0
    [[ "$name" == linux64 ]] || sources || status=$?
    case $status in
    0) names+=("$name") ;;
    1)
        missing+=("$name")
        rm -rf "$binaries/$name"
        ;;
    *) exit 1 ;;
    esac
done
# Two at a time: each takes one core.
status=0
for name in "${names[@]}"; do
    (($(jobs -pr | wc -l) < 2)) || wait -n || status=1
    platform "$name" &
done
while [[ -n "$(jobs -p)" ]]; do
    wait -n || status=1
done
((status == 0)) || exit 1
if ((${#missing[@]})); then
    printf 'missing: %s: no package rust-src of rustc %s is served\n' "${missing[*]}" "$RUST_VERSION"
fi
