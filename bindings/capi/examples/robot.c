/*
 * A robot with a lidar and a satellite receiver, by a joint map, in C11 and without any library but this one:
 *
 *     cc -std=c11 -I<prefix>/include robot.c -L<prefix>/lib -lscphd -lm
 *
 * It goes in circles among twelve posts; its wheels are worn, and it does not know.
 */
#include <math.h>
#include <scphd.h>
#include <stdio.h>
#include <stdlib.h>

/* All memory that there is: static, and zero at first. */
static SCPHD_MEMORY(slam_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(robot_memory, SCPHD_SIZE_DESCRIPTION);

/* What a program does about an error is its own affair; this one gives up. */
static void check(scphd_status status) {
    if (status != SCPHD_STATUS_OK) {
        fprintf(stderr, "%s\n", scphd_error_text(status));
        exit(1);
    }
}

static float uniform(void) {
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / 16777216.0f;
}

/* Nearly normal: the sum of twelve. */
static float noise(float sigma) {
    float sum = -6.0f;
    for (int draw = 0; draw < 12; draw++) {
        sum += uniform();
    }
    return sigma * sum;
}

/* What is set of the robot; everything else is as the header says. */
static const struct {
    uint32_t setting;
    float number;
} SETTINGS[] = {
    {SCPHD_VEHICLE_KIND, SCPHD_VEHICLE_KIND_UNICYCLE},
    {SCPHD_SENSOR_MODEL, SCPHD_SENSOR_MODEL_RANGE_BEARING},
    {SCPHD_SENSOR_RANGE_MAX_M, 12.0f},
    {SCPHD_SENSOR_RANGE_SIGMA_M, 0.05f},
    {SCPHD_SENSOR_BEARING_SIGMA_RAD, 0.01f},
    {SCPHD_SENSOR_RANGE_EDGE_M, 0.15f},
    {SCPHD_SENSOR_FORWARD_M, 0.2f},
    {SCPHD_POSITION, SCPHD_POSITION_YES},
    {SCPHD_POSITION_SIGMA, 0.3f},
    {SCPHD_POSITION_GATE, 25.0f},
    {SCPHD_START_X_M, 5.0f},
    {SCPHD_START_HEADING_RAD, 1.5708f},
};

static scphd_slam *start_slam(void) {
    scphd_reason reason;
    scphd_description *robot = NULL;
    scphd_slam *slam = NULL;
    reason.struct_size = sizeof reason;
    check(scphd_description_start(SCPHD_ABI_VERSION, robot_memory, sizeof robot_memory, &robot));
    for (size_t at = 0; at < sizeof SETTINGS / sizeof SETTINGS[0]; at++) {
        check(scphd_description_set(robot, SETTINGS[at].setting, 0, SETTINGS[at].number, NULL));
    }
    scphd_status status = scphd_start_joint_40(SCPHD_ABI_VERSION, slam_memory, sizeof slam_memory, robot, &reason, &slam);
    if (status != SCPHD_STATUS_OK) {
        fprintf(stderr, "%s: %s%s\n", scphd_setting_name(reason.setting), scphd_setting_range(reason.setting), reason.text);
    }
    check(status);
    check(scphd_slam_reset(slam, robot));
    return slam;
}

int main(void) {
    scphd_slam *slam = start_slam();
    float posts[12][2];
    for (int post = 0; post < 12; post++) {
        posts[post][0] = 20.0f * uniform() - 10.0f;
        posts[post][1] = 20.0f * uniform() - 10.0f;
    }
    float x = 5.0f, y = 0.0f, heading = 1.5708f;
    scphd_scan_report report;
    report.struct_size = sizeof report;
    for (int step = 1; step <= 600; step++) {
        /* The truth: 1 m/s, 0.2 rad/s, ten times a second. */
        x += 0.1f * cosf(heading + 0.01f);
        y += 0.1f * sinf(heading + 0.01f);
        heading += 0.02f;
        check(scphd_slam_predict(slam, 1.04f, 0.0f, 0.206f, 0.1f, NULL));

        scphd_range_bearing scan[32];
        size_t seen = 0;
        for (int post = 0; post < 12; post++) {
            float dx = posts[post][0] - x - 0.2f * cosf(heading), dy = posts[post][1] - y - 0.2f * sinf(heading);
            float range = sqrtf(dx * dx + dy * dy);
            if (range < 12.0f && uniform() < 0.9f) {
                scan[seen].range_m = range + noise(0.05f);
                scan[seen].bearing_rad = remainderf(atan2f(dy, dx) - heading + noise(0.01f), 6.2831853f);
                seen++;
            }
        }
        scan[seen].range_m = 0.1f + 11.9f * uniform();
        scan[seen].bearing_rad = 6.2f * uniform() - 3.1f;
        seen++;
        check(scphd_slam_scan_range_bearing(slam, 0, scan, seen, &report));
        if (report.health != 0) {
            printf("step %d: health %x\n", step, (unsigned)report.health);
        }
        if (step % 100 == 0) {
            check(scphd_slam_observe_position(slam, x + noise(0.3f), y + noise(0.3f), NULL));
        }
    }
    scphd_plane_pose pose;
    scphd_feature features[40];
    scphd_map map;
    pose.struct_size = sizeof pose;
    map.struct_size = sizeof map;
    check(scphd_slam_estimate_pose(slam, &pose));
    check(scphd_slam_estimate_map(slam, features, 40, &map));
    float off = hypotf(pose.x_m - x, pose.y_m - y);
    printf("%.3f m off after a minute, %u of 12 posts; %d bytes of memory\n", (double)off, (unsigned)map.features,
           SCPHD_SIZE_JOINT_40 + SCPHD_SIZE_DESCRIPTION);
    return off < 0.2f && map.features == 12 ? 0 : 1;
}
