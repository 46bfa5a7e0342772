#!/usr/bin/env bash
# Makes sure that Tyndall can be built and run: Rust, a C linker, a Vulkan loader and a driver.
# With --tests also Vulkan's validation layers. Installs what is missing through apt where it may;
# otherwise says what to install and exits 1. Quiet when there is nothing to do.
set -euo pipefail

with_tests=false
case "${1:-}" in
    "") ;;
    --tests) with_tests=true ;;
    *) echo "usage: $0 [--tests]" >&2; exit 2 ;;
esac

has_loader() {
    local list ldconfig
    # Not on every user's PATH.
    ldconfig=$(PATH="$PATH:/sbin:/usr/sbin" command -v ldconfig) || return 1
    list=$("$ldconfig" -p 2>/dev/null) || return 1
    [[ $list == *libvulkan.so.1* ]]
}

# True if a file of the pattern $2 lies in `vulkan/$1` of a folder that the loader searches.
has_manifest() {
    local folder
    for folder in /usr/share /etc /usr/local/share /usr/local/etc "${XDG_DATA_HOME:-$HOME/.local/share}"; do
        if compgen -G "$folder/vulkan/$1/$2" >/dev/null; then
            return 0
        fi
    done
    return 1
}

has_driver() {
    local listed=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}} file
    if [[ -z $listed ]]; then
        has_manifest icd.d '*.json'
        return
    fi
    # Paths with colons between them; a folder stands for the files in it.
    local IFS=:
    for file in $listed; do
        if [[ -f $file ]] || compgen -G "$file/*.json" >/dev/null; then
            return 0
        fi
    done
    return 1
}

# The tests compare images on this driver unless another one is named.
needs_lavapipe() {
    $with_tests && [[ -z ${TYNDALL_TEST_DRIVER:-} ]]
}

has_validation() {
    [[ -n ${VK_LAYER_PATH:-} ]] && compgen -G "$VK_LAYER_PATH/VkLayer_khronos_validation*.json" >/dev/null && return 0
    has_manifest explicit_layer.d 'VkLayer_khronos_validation*.json'
}

# Sets `missing` (what is not there) and `packages` (what brings it on Debian and Ubuntu).
survey() {
    missing=() packages=()
    if ! command -v cc >/dev/null; then
        missing+=("a C linker (cc)")
        packages+=(gcc libc6-dev)
    fi
    if ! has_loader; then
        missing+=("the Vulkan loader (libvulkan.so.1)")
        packages+=(libvulkan1)
    fi
    if needs_lavapipe && ! has_manifest icd.d 'lvp_icd*.json'; then
        missing+=("Mesa's software Vulkan driver (lavapipe)")
        packages+=(mesa-vulkan-drivers)
    elif ! has_driver; then
        missing+=("a Vulkan driver")
        packages+=(mesa-vulkan-drivers)
    fi
    if $with_tests && ! has_validation; then
        missing+=("Vulkan's validation layers")
        packages+=(vulkan-validationlayers)
    fi
}

# Runs a command as root, or fails where that would need a password.
as_root() {
    if [[ $(id -u) == 0 ]]; then
        "$@"
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo -n "$@"
    else
        return 1
    fi
}

install_with_apt() {
    command -v apt-get >/dev/null && as_root true || return 1
    local log
    log=$(mktemp)
    if as_root apt-get -qq update >"$log" 2>&1 &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends \
            install "${packages[@]}" >>"$log" 2>&1; then
        rm -f "$log"
        return 0
    fi
    cat "$log" >&2
    rm -f "$log"
    return 1
}

# The command that installs everything, for the package manager that is here.
advice() {
    local layers=""
    if command -v apt-get >/dev/null; then
        echo "    sudo apt-get update && sudo apt-get install ${packages[*]}"
    elif command -v dnf >/dev/null; then
        $with_tests && layers=" vulkan-validation-layers"
        echo "    sudo dnf install gcc vulkan-loader mesa-vulkan-drivers$layers"
    elif command -v pacman >/dev/null; then
        $with_tests && layers=" vulkan-validation-layers"
        echo "    sudo pacman -S --needed gcc vulkan-icd-loader vulkan-swrast$layers"
    elif command -v zypper >/dev/null; then
        $with_tests && layers=" vulkan-validationlayers"
        echo "    sudo zypper install gcc libvulkan1 libvulkan_lvp$layers"
    else
        echo "    a C compiler, the Vulkan loader and a Vulkan driver (Mesa's lavapipe needs no GPU)"
        ! $with_tests || echo "    Vulkan's validation layers"
    fi
}

if ! command -v cargo >/dev/null; then
    echo "setup: Rust is missing (cargo is not on the PATH). Install it with rustup." >&2
    exit 1
fi

survey
if ((${#missing[@]} > 0)); then
    install_with_apt || true
    survey
fi
if ((${#missing[@]} > 0)); then
    {
        echo "setup: missing:"
        printf '    %s\n' "${missing[@]}"
        echo "setup: install with:"
        advice
    } >&2
    exit 1
fi
