#!/bin/sh
# The C tests once more, under what finds faults that a passing test hides: sanitizers, valgrind and the
# compiler's static analyzer. What this machine lacks is skipped with a reason.
#
#   hardened.sh BUILD PYTHON     BUILD holds the plain build (make ctest); cmake and ninja are on the path
set -eu
build=$1
python=$2
source=$(dirname "$0")/..
cc() { eval "${CC:-command cc}" '"$@"'; } # CC may hold a quoted path and flags
probe=$build/probe

skip() {
    echo "hardened: skipped: $*"
}

supports() { # flags: does a program built with them run?
    echo 'int main(void) { return 0; }' > "$probe.c"
    cc "$@" "$probe.c" -o "$probe" 2> /dev/null && "$probe" 2> /dev/null
}

side_by_side() { # runs each line that is read as a command, two at a time; fails where one does
    tr '\n' '\0' | xargs -0 -n 1 -P 2 sh -c
}

configure() { # directory, sanitizers
    cmake -S "$source" -B "$1" -G Ninja -DPython_EXECUTABLE="$python" -DIT2HYS_SANITIZE="$2" > /dev/null
}

undefined=address,undefined,float-cast-overflow
if supports -fsanitize=$undefined; then
    configure "$build/address" $undefined
    cmake --build "$build/address" > /dev/null
    ctest --test-dir "$build/address" --output-on-failure --quiet -j 2
    echo "hardened: C tests pass under $undefined"
else
    skip "the compiler has no -fsanitize=$undefined here"
fi

if supports -fsanitize=thread; then
    configure "$build/thread" thread
    cmake --build "$build/thread" --target test_threads > /dev/null
    "$build/thread/tests/test_threads"
    echo "hardened: 1000 instances in 8 threads pass under ThreadSanitizer"
else
    skip "the compiler has no -fsanitize=thread here"
fi

if command -v valgrind > /dev/null; then
    check="valgrind --quiet --error-exitcode=1 --leak-check=full"
    definite="$check --show-leak-kinds=definite"
    cd "$build/tests"
    for test in lifecycle variables parameters state derivatives log; do
        echo "$check ./test_fmi2_$test > /dev/null"
    done > valgrind_jobs
    for target in calls fmi3; do
        echo "$definite ../fuzz/fuzz_$target -n 500"
    done >> valgrind_jobs
    side_by_side < valgrind_jobs
    cd - > /dev/null
    echo "hardened: FMI tests and 500 fuzzed sequences of each version pass under valgrind"
else
    skip "valgrind is not installed"
fi

if supports -fanalyzer; then
    headers=$("$python" -c "import fmpy; print(fmpy.__path__[0])")/c-code
    analyze="${CC:-command cc} -std=c99 -O2 -fanalyzer -fdiagnostics-path-format=none -Werror -c -o /dev/null
        -I'$source/core' -I'$source/fmi' -I'$source/models' -I'$build/generated' -isystem '$headers'"
    for file in "$source"/core/*.c "$source"/fmi/*.c "$source"/models/*.c \
        "$source"/identification/*.c "$source"/python/stepper.c; do
        echo $analyze "'$file'"
    done | side_by_side
    echo "hardened: -fanalyzer finds nothing"
else
    skip "the compiler has no -fanalyzer"
fi
