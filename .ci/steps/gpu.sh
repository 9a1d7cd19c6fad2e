# Kernels in WGSL against the Rust that they follow. Mesa's software runs them; a card is not needed.
drivers=(/usr/share/vulkan/icd.d/lvp_icd.*.json)
if [[ ! -e ${drivers[0]} ]]; then
    echo "warning: no software of Mesa's for Vulkan (mesa-vulkan-drivers) is to be had: kernels are not tested"
    exit 0
fi
export VK_DRIVER_FILES=${drivers[0]} PHOTOSITE_GPU=0
# Of all crates, as with --package alone what they stand on would be compiled again with fewer features.
cargo test --release --locked --features gpu --test kernels --test on_card
