/* The loop of docs/c.md, as part of a program that has sensors. */
#include <scphd.h>

static SCPHD_MEMORY(slam_memory, SCPHD_SIZE_JOINT_40);           /* all memory of the filter: static, zero */
static SCPHD_MEMORY(robot_memory, SCPHD_SIZE_DESCRIPTION);

/* What this vehicle has. */
extern float speed_mps, rate_radps, dt_s, x_m, y_m;
extern scphd_range_bearing scan[32];
extern size_t count;

/* Waits for the next scan; what is written here without a look at the status is looked at in robot.c. */
extern void wait_for_scan(void);
void drive(void);

void drive(void) {
    scphd_scan_report report = {.struct_size = sizeof report};
    scphd_plane_pose pose = {.struct_size = sizeof pose};

    scphd_description *robot;                                        /* a robot with a joint map */
    scphd_description_start(SCPHD_ABI_VERSION, robot_memory, sizeof robot_memory, &robot);
    scphd_description_set(robot, SCPHD_SENSOR_MODEL, 0, SCPHD_SENSOR_MODEL_RANGE_BEARING, NULL);
    scphd_description_set(robot, SCPHD_SENSOR_RANGE_SIGMA_M, 0, 0.1f, NULL);
    scphd_description_set(robot, SCPHD_SENSOR_BEARING_SIGMA_RAD, 0, 0.01f, NULL);
    scphd_description_set(robot, SCPHD_POSITION, 0, SCPHD_POSITION_YES, NULL);
    scphd_description_set(robot, SCPHD_POSITION_SIGMA, 0, 0.5f, NULL);
    scphd_slam *slam;
    scphd_start_joint_40(SCPHD_ABI_VERSION, slam_memory, sizeof slam_memory, robot, NULL, &slam);
    scphd_slam_reset(slam, robot);
    for (;;) {
        wait_for_scan();
        scphd_slam_predict(slam, speed_mps, 0.0f, rate_radps, dt_s, NULL);     /* every odometry sample */
        scphd_slam_scan_range_bearing(slam, 0, scan, count, &report);          /* every scan of any sensor */
        scphd_slam_observe_position(slam, x_m, y_m, NULL);                     /* every measurement of the pose itself */
        scphd_slam_estimate_pose(slam, &pose);                                 /* mean and covariance */
    }
}
