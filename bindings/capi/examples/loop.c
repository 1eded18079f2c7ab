/* The loop of docs/c.md, as part of a program that has sensors. */
#include <scphd.h>

static SCPHD_MEMORY(slam_memory, SCPHD_SIZE_JOINT_40);           /* all memory there is: static, zero */
static SCPHD_MEMORY(lidar_memory, SCPHD_SIZE_RANGE_BEARING_32);

/* What this vehicle has. */
extern float speed_mps, rate_radps, dt_s, x_m, y_m;
extern scphd_range_bearing scan[32];
extern size_t count;

/* Waits for the next scan; what is written here without a look at the status is looked at in robot.c. */
extern void wait_for_scan(void);
void drive(void);

void drive(void) {
    scphd_range_bearing_config seeing = {.struct_size = sizeof seeing};
    scphd_range_bearing_detector *lidar;
    scphd_joint_report report = {.struct_size = sizeof report};
    scphd_plane_pose pose = {.struct_size = sizeof pose};
    const scphd_fix gps = {.struct_size = sizeof gps, .sigma = 0.5f};
    scphd_range_bearing_defaults(&seeing, 15.0f, 0.9f);
    seeing.range_sigma_m = 0.1f;
    seeing.bearing_sigma_rad = 0.01f;
    scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, lidar_memory, sizeof lidar_memory, &seeing, NULL,
                              &lidar);

    scphd_joint_config config = {.struct_size = sizeof config};
    scphd_joint_defaults(&config);
    scphd_joint *slam;
    scphd_joint_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, slam_memory, sizeof slam_memory, &config, NULL, &slam);
    scphd_joint_reset(slam, 0.0f, 0.0f, 0.0f);
    for (;;) {
        wait_for_scan();
        scphd_joint_predict_robot(slam, speed_mps, rate_radps, dt_s, NULL);    /* every odometry sample */
        scphd_joint_scan_range_bearing(slam, lidar, scan, count, &report);     /* every scan of any sensor */
        scphd_joint_observe_position(slam, &gps, x_m, y_m, NULL);              /* every measurement of the pose itself */
        scphd_joint_estimate_pose(slam, &pose);                                /* mean and covariance */
    }
}
