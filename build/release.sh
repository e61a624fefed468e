#!/usr/bin/env bash
# The files of a release, into dist/: `build/release.sh`, on x86-64 Debian, from the commit that will get the tag.
#
#     build/release.sh [--dry-run]
#
# - the wheels, for Linux on x86-64 with glibc 2.17 or later, and for Windows on x86-64;
# - gelfmu alone, the program of the wheel for Linux, with its manual pages and the licences;
# - the FMU of fbi-bb, with the libraries of every platform;
# - the crate;
# - SHA256SUMS of all.
#
# The tree must be clean, and CHANGELOG.md must have a section of the version of Cargo.toml with its date, which --dry-run
# does not ask for. Nothing is published: the last lines list sizes and seconds, and say how. Tools are those of
# build/platforms.sh and build/wheel.sh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

TOOLS="${BALLISTIC_GEL_TOOLS:-${CARGO_HOME:-$HOME/.cargo}/ballistic-gel-ci}"
PLATFORMS=linux64,win64,aarch64-linux,darwin64
VERSION=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
DIST="$PWD/dist"
dry=
case "${1:-}" in
'') ;;
--dry-run) dry=yes ;;
*) printf 'release: unknown option %s: the only one is --dry-run\n' "$1" >&2 && exit 2 ;;
esac
times=()

refuse() {
    printf 'release: %s\n' "$1" >&2
    exit 1
}

check() {
    [[ -n "$VERSION" ]] || refuse 'Cargo.toml: found no version'
    [[ -z "$(git status --porcelain)" ]] || refuse 'the tree has changes: commit or stash them'
    [[ -n "$dry" ]] || grep --quiet --extended-regexp "^## \[${VERSION//./\\.}\] - [0-9]{4}-[0-9]{2}-[0-9]{2}$" CHANGELOG.md ||
        refuse "CHANGELOG.md: found no section \"## [$VERSION] - YYYY-MM-DD\": give the section of this version its date"
}

# The wheels, linked by zig, which is that of build/platforms.sh: for Linux against the C library of manylinux2014, for
# Windows with the standard library built from its sources, as in build/platforms.sh.
wheels() {
    local sources
    sources="$TOOLS/rust-src-$(rustc --version | cut -d' ' -f2)/library"
    export CARGO_ZIGBUILD_ZIG_PATH="$TOOLS/platforms/zig" PATH="$TOOLS/platforms:$PATH"
    build/wheel.sh --zig --compatibility manylinux2014 --out "$DIST"
    RUSTC_BOOTSTRAP=1 __CARGO_TESTS_ONLY_SRC_ROOT=$sources CARGO_UNSTABLE_BUILD_STD=std,panic_unwind RUSTFLAGS=-Zhas-thread-local=yes \
        build/wheel.sh --zig --target x86_64-pc-windows-gnu --out "$DIST"
}

# The program of the wheel, and the FMU that it packs; it refuses a platform whose library it does not hold. Both are tested, the
# libraries on the platforms that wine and qemu, from Debian, stand for here.
archives() {
    local made name="gelfmu-$VERSION-x86_64-linux"
    made=$(mktemp -d)
    python3 -m zipfile --extract "$DIST"/*manylinux*.whl "$made/wheel"
    install -D -m 755 "$made"/wheel/*.data/scripts/gelfmu "$made/$name/gelfmu"
    "$made/$name/gelfmu" man --out "$made/$name/man1" --quiet
    cp LICENSE-APACHE LICENSE-MIT CHANGELOG.md "$made/$name"
    tar --create --gzip --file "$DIST/$name.tar.gz" --directory "$made" --owner 0 --group 0 --sort name \
        --mtime "@$(git log -1 --format=%ct)" "$name"
    "$made/$name/gelfmu" pack fbi-bb --platforms "$PLATFORMS" --out "$DIST/fbi-bb-$VERSION.fmu"
    # CI runs libraries that are optimized less.
    python3 tests/platforms/run.py "$made/$name/gelfmu" "$TOOLS/platforms/zig"
    BALLISTIC_GEL_RELEASE="$made/$name/gelfmu" cargo test --release --locked --test conformance
    rm -rf "$made"
}

crate() {
    cargo package --locked
    cp "target/package/ballistic-gel-$VERSION.crate" "$DIST"
}

# part NAME COMMAND...: runs a part of the release, and notes its seconds.
part() {
    local name=$1 start=$SECONDS
    shift
    "$@"
    times+=("$name $((SECONDS - start)) s")
}

check
rm -rf "$DIST"
mkdir "$DIST"
part libraries build/platforms.sh
part wheels wheels
part archives archives
part crate crate
(cd "$DIST" && sha256sum -- * >SHA256SUMS && cat SHA256SUMS)
printf '\n'
(cd "$DIST" && stat --format '%n: %s bytes' -- *)
printf '%s\n' "${times[@]}"
printf '\nrelease %s is in dist/. To publish it: git tag --annotate v%s, push the tag, and upload the files.\n' "$VERSION" "$VERSION"
