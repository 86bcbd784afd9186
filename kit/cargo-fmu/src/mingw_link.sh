#!/bin/sh
# Links for Windows to the same bytes in every folder: the GNU linker puts imports in the order of the paths of the archives that name
# them, so archives get names here that only their order in the command decides.
set -e
names=$(mktemp -d)
trap 'rm -rf "$names"' EXIT
count=10000
for argument do
    shift
    case $argument in
        /*.rlib | /*.a | /*.lib)
            count=$((count + 1))
            ln -s "$argument" "$names/$count.${argument##*.}"
            argument=$count.${argument##*.}
            ;;
    esac
    set -- "$@" "$argument"
done
# Relative names, which come before those of the linker's own libraries wherever these lie.
cd "$names"
x86_64-w64-mingw32-gcc "$@"
