/* Links with another archive in Rust, and calls both. */
#include "check.h"

extern uint32_t other_share(uint32_t all, uint32_t parts);

int main(void) {
    HOLDS(other_share(12, 4) == 3);
    HOLDS(scphd_abi_version() == SCPHD_ABI_VERSION);
    static SCPHD_MEMORY(memory, SCPHD_SIZE_JOINT_40);
    static SCPHD_MEMORY(robot_memory, SCPHD_SIZE_DESCRIPTION);
    scphd_description *robot = NULL;
    scphd_slam *slam = NULL;
    OK(scphd_description_start(SCPHD_ABI_VERSION, robot_memory, sizeof robot_memory, &robot));
    OK(scphd_start_joint_40(SCPHD_ABI_VERSION, memory, sizeof memory, robot, NULL, &slam));
    return failures == 0 ? 0 : 1;
}
