/* Takes in the inputs of a file that scphd-drive has written, and compares the states with those of the library without C. */
#include "check.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#ifndef REPLAY_FILE
#define REPLAY_FILE NULL
#endif

/* How many scans to compare, at most. */
#ifndef REPLAY_SCANS
#define REPLAY_SCANS 1000000
#endif

enum { NUMBERS = 128 };

static SCPHD_MEMORY(blind_memory, SCPHD_SIZE_PLANE_32X2);
static SCPHD_MEMORY(informed_memory, SCPHD_SIZE_PLANE_INFORMED_4_MOVING);
static SCPHD_MEMORY(joint_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(water_memory, SCPHD_SIZE_WATER_INFORMED_16);
static SCPHD_MEMORY(lidar_memory, SCPHD_SIZE_RANGE_BEARING_32);
static SCPHD_MEMORY(radar_memory, SCPHD_SIZE_RANGE_BEARING_128);
static SCPHD_MEMORY(camera_memory, SCPHD_SIZE_BEARING_64);
static SCPHD_MEMORY(sonar_memory, SCPHD_SIZE_SONAR_64);

static scphd_plane *blind, *informed;
static scphd_joint *joint;
static scphd_water *water;
static scphd_range_bearing_detector *lidar, *radar;
static scphd_bearing_detector *camera;
static scphd_sonar_detector *sonar;

static void start_filters(void) {
    scphd_plane_config plane;
    plane.struct_size = sizeof plane;
    OK(scphd_plane_blind(&plane, 32, 2));
    const scphd_vehicle robot = plane.vehicle;
    OK(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_32X2, blind_memory, sizeof blind_memory, &plane, NULL, &blind));
    OK(scphd_plane_reset(blind, 5.0f, 0.0f, 1.5f, 7));

    OK(scphd_plane_informed(&plane, 4));
    plane.vehicle = robot;
    plane.tuning.prune_weight = 1e-3f;
    OK(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4_MOVING, informed_memory, sizeof informed_memory, &plane,
                         NULL, &informed));
    OK(scphd_plane_reset(informed, 5.0f, 0.0f, 1.5f, 8));

    scphd_joint_config map;
    map.struct_size = sizeof map;
    OK(scphd_joint_defaults(&map));
    map.vehicle = robot;
    OK(scphd_joint_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, joint_memory, sizeof joint_memory, &map, NULL, &joint));
    OK(scphd_joint_reset(joint, 5.0f, 0.0f, 1.5f));

    scphd_water_config dive;
    dive.struct_size = sizeof dive;
    OK(scphd_water_informed(&dive, 16));
    dive.yaw_acceleration_sigma_radps2 = 0.1f;
    dive.velocity_interval_s = 1.0f;
    OK(scphd_water_start(SCPHD_ABI_VERSION, SCPHD_SET_WATER_INFORMED_16, water_memory, sizeof water_memory, &dive, NULL, &water));
    OK(scphd_water_reset(water, 2.0f, 0.0f, -1.0f, 1.5f, 9));
}

static void start_detectors(void) {
    scphd_range_bearing_config polar;
    polar.struct_size = sizeof polar;
    OK(scphd_range_bearing_defaults(&polar, 12.0f, 0.85f));
    polar.range_sigma_m = 0.05f;
    polar.bearing_sigma_rad = 0.01f;
    polar.window.range_edge_m = 3.0f * polar.range_sigma_m;
    polar.window.bearing_edge_rad = 3.0f * polar.bearing_sigma_rad;
    polar.window.bearing_half_width_rad = 2.0f;
    polar.clutter_per_scan = 2.0f;
    polar.births_still = 0.002f;
    polar.births_moving = 0.001f;
    polar.mounting.forward_m = 0.22f;
    polar.mounting.yaw_rad = 0.5f;
    OK(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, lidar_memory, sizeof lidar_memory, &polar, NULL,
                                 &lidar));

    OK(scphd_range_bearing_defaults(&polar, 20.0f, 0.85f));
    polar.range_sigma_m = 0.2f;
    polar.bearing_sigma_rad = 0.03f;
    polar.window.range_edge_m = 3.0f * polar.range_sigma_m;
    polar.window.bearing_edge_rad = 3.0f * polar.bearing_sigma_rad;
    polar.window.bearing_half_width_rad = 0.8f;
    polar.births_still = 0.003f;
    polar.mounting.forward_m = -0.3f;
    polar.mounting.left_m = 0.1f;
    polar.mounting.yaw_rad = 3.0f;
    OK(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_128, radar_memory, sizeof radar_memory, &polar, NULL,
                                 &radar));

    scphd_bearing_config direction;
    direction.struct_size = sizeof direction;
    OK(scphd_bearing_defaults(&direction, 12.0f, 0.85f));
    direction.bearing_sigma_rad = 0.02f;
    direction.window.bearing_half_width_rad = 2.0f;
    direction.births_nearest_m = 2.0f;
    direction.births_rings = 3;
    direction.births_sectors = 16;
    direction.births_weight = 0.0005f;
    direction.mounting.forward_m = 0.22f;
    direction.mounting.yaw_rad = 0.5f;
    OK(scphd_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_BEARING_64, camera_memory, sizeof camera_memory, &direction, NULL, &camera));

    scphd_sonar_config spherical;
    spherical.struct_size = sizeof spherical;
    OK(scphd_sonar_defaults(&spherical, 8.0f, 0.9f));
    spherical.range_sigma_m = 0.05f;
    spherical.bearing_sigma_rad = 0.02f;
    spherical.elevation_sigma_rad = 0.02f;
    spherical.range_edge_m = 0.15f;
    spherical.births_still = 0.001f;
    OK(scphd_sonar_start(SCPHD_ABI_VERSION, SCPHD_SET_SONAR_64, sonar_memory, sizeof sonar_memory, &spherical, NULL, &sonar));
}

static void take(char letter, const float *numbers, size_t count) {
    const scphd_range_bearing *polar = (const scphd_range_bearing *)numbers;
    scphd_fix fix = {sizeof fix, 0.0f, 0.0f, 0.0f, 0.0f};
    scphd_water_control control;
    switch (letter) {
    case 'p':
        OK(scphd_plane_predict_robot(blind, numbers[0], numbers[1], numbers[2], NULL));
        OK(scphd_plane_predict_robot(informed, numbers[0], numbers[1], numbers[2], NULL));
        OK(scphd_joint_predict_robot(joint, numbers[0], numbers[1], numbers[2], NULL));
        break;
    case 'l':
    case 'r': {
        scphd_range_bearing_detector *detector = letter == 'l' ? lidar : radar;
        OK(scphd_plane_scan_range_bearing(blind, detector, polar, count / 2, NULL));
        OK(scphd_plane_scan_range_bearing(informed, detector, polar, count / 2, NULL));
        OK(scphd_joint_scan_range_bearing(joint, detector, polar, count / 2, NULL));
        break;
    }
    case 'c':
        OK(scphd_plane_scan_bearing(blind, camera, numbers, count, NULL));
        break;
    case 'g':
        fix.sigma = 0.3f;
        fix.gate = 25.0f;
        fix.antenna_forward_m = -0.5f;
        fix.antenna_left_m = 0.1f;
        OK(scphd_plane_observe_position(blind, &fix, numbers[0], numbers[1], NULL));
        OK(scphd_plane_observe_position(informed, &fix, numbers[0], numbers[1], NULL));
        OK(scphd_joint_observe_position(joint, &fix, numbers[0], numbers[1], NULL));
        break;
    case 'h':
        fix.sigma = 0.05f;
        OK(scphd_plane_observe_heading(blind, &fix, numbers[0], NULL));
        OK(scphd_plane_observe_heading(informed, &fix, numbers[0], NULL));
        OK(scphd_joint_observe_heading(joint, &fix, numbers[0], NULL));
        break;
    case 'd':
        memset(&control, 0, sizeof control);
        control.struct_size = sizeof control;
        memcpy(control.velocity_mps, numbers, sizeof control.velocity_mps);
        control.velocity_covariance[0] = 0.01f;
        control.velocity_covariance[2] = 0.01f;
        control.velocity_covariance[5] = 0.01f;
        control.yaw_rate_radps = numbers[3];
        control.yaw_rate_sigma_radps = 0.02f;
        control.z_m = numbers[4];
        control.z_sigma_m = 0.05f;
        OK(scphd_water_predict(water, &control, numbers[5], NULL));
        break;
    case 's':
        OK(scphd_water_scan_sonar(water, sonar, (const scphd_sonar *)numbers, count / 3, NULL));
        break;
    case 'z':
        fix.sigma = 0.1f;
        OK(scphd_water_observe_height(water, &fix, numbers[0], NULL));
        break;
    default:
        HOLDS(!"a letter that is known");
    }
}

static void compare(const uint64_t wanted[4], int scan) {
    uint64_t got[4] = {0, 0, 0, 0};
    OK(scphd_plane_digest(blind, &got[0]));
    OK(scphd_plane_digest(informed, &got[1]));
    OK(scphd_joint_digest(joint, &got[2]));
    OK(scphd_water_digest(water, &got[3]));
    if (memcmp(got, wanted, sizeof got) != 0) {
        printf("scan %d: %016" PRIx64 " %016" PRIx64 " %016" PRIx64 " %016" PRIx64 "\n", scan, got[0], got[1], got[2], got[3]);
        failures++;
    }
}

int main(int count_of_words, char **words) {
    const char *path = count_of_words > 1 ? words[1] : REPLAY_FILE;
    FILE *file = path == NULL ? NULL : fopen(path, "r");
    if (file == NULL) {
        printf("no file to replay\n");
        return 2;
    }
    start_filters();
    start_detectors();
    int scans = 0;
    char letter;
    unsigned length;
    while (failures == 0 && scans < REPLAY_SCANS && fscanf(file, " %c %u", &letter, &length) == 2) {
        if (letter == '=') {
            uint64_t wanted[4];
            for (unsigned at = 0; at < 4; at++) {
                HOLDS(fscanf(file, "%" SCNx64, &wanted[at]) == 1);
            }
            compare(wanted, scans);
            scans++;
        } else {
            float numbers[NUMBERS];
            HOLDS(length <= NUMBERS);
            for (unsigned at = 0; at < length && at < NUMBERS; at++) {
                uint32_t bits = 0;
                HOLDS(fscanf(file, "%" SCNx32, &bits) == 1);
                memcpy(&numbers[at], &bits, sizeof bits);
            }
            take(letter, numbers, length);
        }
    }
    fclose(file);
    HOLDS(scans > 0);
    printf("%d scans, %d failures\n", scans, failures);
    return failures == 0 ? 0 : 1;
}
