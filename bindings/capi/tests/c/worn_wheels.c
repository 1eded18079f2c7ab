/* A robot whose wheels are 2 % smaller than it takes them to be, with the defaults and the numbers of a data sheet, as docs/c.md has it. */
#include "check.h"
#include <math.h>

#define POSTS 40
#define SECONDS 300
static const float PI = 3.14159265f;

static SCPHD_MEMORY(slam_memory, SCPHD_SIZE_JOINT_100);
static SCPHD_MEMORY(robot_memory, SCPHD_SIZE_DESCRIPTION);

static uint32_t state;

static float uniform(void) {
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / 16777216.0f;
}

/* Nearly normal: the sum of twelve. */
static float normal(float sigma) {
    float sum = -6.0f;
    for (int draw = 0; draw < 12; draw++) {
        sum += uniform();
    }
    return sigma * sum;
}

static float wrapped(float angle) {
    return angle - 2.0f * PI * floorf(angle / (2.0f * PI) + 0.5f);
}

static void drive(uint32_t seed) {
    state = seed;
    float posts[POSTS][2];
    for (int post = 0; post < POSTS; post++) {
        posts[post][0] = 24.0f * uniform() - 12.0f;
        posts[post][1] = 24.0f * uniform() - 12.0f;
    }
    scphd_description *robot;
    OK(scphd_description_start(SCPHD_ABI_VERSION, robot_memory, sizeof robot_memory, &robot));
    OK(scphd_description_set(robot, SCPHD_SENSOR_MODEL, 0, SCPHD_SENSOR_MODEL_RANGE_BEARING, NULL));
    OK(scphd_description_set(robot, SCPHD_SENSOR_RANGE_MAX_M, 0, 10.0f, NULL));
    OK(scphd_description_set(robot, SCPHD_SENSOR_RANGE_SIGMA_M, 0, 0.05f, NULL));
    OK(scphd_description_set(robot, SCPHD_SENSOR_BEARING_SIGMA_RAD, 0, 0.01f, NULL));
    scphd_slam *slam;
    OK(scphd_start_joint_100(SCPHD_ABI_VERSION, slam_memory, sizeof slam_memory, robot, NULL, &slam));
    float x = 6.0f, y = 0.0f, heading = 0.5f * PI;
    OK(scphd_description_set(robot, SCPHD_START_X_M, 0, x, NULL));
    OK(scphd_description_set(robot, SCPHD_START_HEADING_RAD, 0, heading, NULL));
    OK(scphd_slam_reset(slam, robot));

    double squares = 0.0, nees = 0.0;
    int scans = 0;
    for (int row = 1; row <= 50 * SECONDS; row++) {
        const float speed = 0.8f, rate = speed / 6.0f, dt = 0.02f;
        x += speed * dt * cosf(heading + 0.5f * rate * dt);
        y += speed * dt * sinf(heading + 0.5f * rate * dt);
        heading += rate * dt;
        OK(scphd_slam_predict(slam, 1.02f * speed + normal(0.01f), 0.0f, 1.02f * rate + normal(0.01f), dt, NULL));
        if (row % 5 != 0) {
            continue;
        }
        scphd_range_bearing scan[32];
        size_t count = 0;
        for (int post = 0; post < POSTS && count < 31; post++) {
            const float dx = posts[post][0] - x, dy = posts[post][1] - y, range = hypotf(dx, dy);
            if (range < 10.0f && uniform() < 0.9f) {
                scan[count].range_m = range + normal(0.05f);
                scan[count].bearing_rad = wrapped(atan2f(dy, dx) - heading + normal(0.01f));
                count++;
            }
        }
        scphd_scan_report report = {.struct_size = sizeof report};
        scphd_plane_pose pose = {.struct_size = sizeof pose};
        OK(scphd_slam_scan_range_bearing(slam, 0, scan, count, &report));
        OK(scphd_slam_estimate_pose(slam, &pose));
        const double off[2] = {pose.x_m - x, pose.y_m - y};
        const double a = pose.covariance[0], b = pose.covariance[1], c = pose.covariance[4];
        squares += off[0] * off[0] + off[1] * off[1];
        nees += (c * off[0] * off[0] - 2.0 * b * off[0] * off[1] + a * off[1] * off[1]) / (a * c - b * b) / 2.0;
        scans++;
    }
    const double rmse = sqrt(squares / scans);
    printf("seed %u: RMSE %.3f m, NEES/2 %.2f\n", seed, rmse, nees / scans);
    HOLDS(rmse < 0.05);
    HOLDS(nees / scans < 2.0);
    scphd_release(slam_memory, sizeof slam_memory);
    scphd_release(robot_memory, sizeof robot_memory);
}

int main(void) {
    for (uint32_t seed = 1; seed <= 3; seed++) {
        drive(seed);
    }
    return failures != 0;
}
