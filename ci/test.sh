#!/usr/bin/env bash
# Every check, in the order in which failures are cheapest: format, lints, docs, tests.
#
# Images are compared on one pinned Vulkan driver, lavapipe. TYNDALL_TEST_DRIVER names another
# driver's manifest (an icd.d/*.json file). TYNDALL_DATA names a folder of data sets; unset, it is
# ../shared/data where that exists.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

pin_driver() {
    local driver=${TYNDALL_TEST_DRIVER:-} found=() folder
    if [[ -z $driver ]]; then
        for folder in /usr/share /etc /usr/local/share /usr/local/etc; do
            mapfile -t -O "${#found[@]}" found < <(compgen -G "$folder/vulkan/icd.d/lvp_icd*.json")
        done
        # A machine can hold the driver for several architectures.
        for driver in "${found[@]}"; do
            [[ $driver != *".$(uname -m).json" ]] || break
        done
    fi
    if [[ ! -f $driver ]]; then
        echo "test: no driver manifest '${driver:-lvp_icd*.json}';" \
            "install Mesa's Vulkan drivers or set TYNDALL_TEST_DRIVER" >&2
        exit 1
    fi
    # The second name is what loaders before 1.3.207 read.
    export VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver
}

# Prints a headline, runs a command, prints its time.
step() {
    local start=$SECONDS
    echo "==> $*"
    "$@" || return
    echo "==> $((SECONDS - start)) s"
}

show_device() {
    echo "==> driver: $VK_DRIVER_FILES"
    if command -v vulkaninfo >/dev/null; then
        vulkaninfo --summary 2>/dev/null | grep -E 'deviceName|driverInfo|apiVersion' || true
    fi
}

all_tests() {
    if cargo nextest --version >/dev/null 2>&1; then
        # nextest does not run the examples in the documentation.
        local status=0
        step cargo nextest run --locked --no-fail-fast || status=$?
        step cargo test --doc --locked || status=$?
        return "$status"
    fi
    step cargo test --locked --no-fail-fast
}

# Runs all tests and ends with one line that sums up what each runner reported.
run_tests() {
    local status=0
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    all_tests 2>&1 | tee "$log" || status=$?
    # nextest counts a test that timed out apart from one that failed: both did not pass.
    awk '
        function number_before(word) { return match($0, "[0-9]+ " word) ? substr($0, RSTART) + 0 : 0 }
        /^ *Summary \[/ { ran = number_before("tests? run"); passed += number_before("passed")
            failed += ran - number_before("passed") }
        /^test result:/ { passed += number_before("passed"); failed += number_before("failed") }
        END { printf "%d passed, %d failed\n", passed, failed }' "$log"
    return "$status"
}

ci/setup.sh --tests
pin_driver

target=${CARGO_TARGET_DIR:-$PWD/target}
# Shaders that the driver has compiled are kept between runs.
export MESA_SHADER_CACHE_DIR=$target/mesa-shader-cache
mkdir -p "$MESA_SHADER_CACHE_DIR"
if [[ -z ${TYNDALL_DATA:-} && -d ../shared/data ]]; then
    TYNDALL_DATA=$(cd ../shared/data && pwd)
    export TYNDALL_DATA
fi

show_device
step cargo fmt --check
step cargo clippy --all-targets --locked -- -D warnings
RUSTDOCFLAGS="-D warnings" step cargo doc --no-deps --locked
run_tests
