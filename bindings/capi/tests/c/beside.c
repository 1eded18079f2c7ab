/* Links with another archive in Rust, and calls both. */
#include "check.h"

extern uint32_t other_share(uint32_t all, uint32_t parts);

int main(void) {
    HOLDS(other_share(12, 4) == 3);
    HOLDS(scphd_abi_version() == SCPHD_ABI_VERSION);
    static SCPHD_MEMORY(memory, SCPHD_SIZE_JOINT_40);
    scphd_joint_config config;
    config.struct_size = sizeof config;
    OK(scphd_joint_defaults(&config));
    scphd_joint *slam = NULL;
    OK(scphd_joint_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, memory, sizeof memory, &config, NULL, &slam));
    return failures == 0 ? 0 : 1;
}
