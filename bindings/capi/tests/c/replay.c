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

static SCPHD_MEMORY(blind_memory, SCPHD_SIZE_MIXTURE_32X2);
static SCPHD_MEMORY(informed_memory, SCPHD_SIZE_MIXTURE_INFORMED_4_MOVING);
static SCPHD_MEMORY(joint_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(movers_memory, SCPHD_SIZE_JOINT_60_MOVERS);
static SCPHD_MEMORY(archive_memory, SCPHD_SIZE_JOINT_40_ARCHIVE);
static SCPHD_MEMORY(learning_memory, SCPHD_SIZE_JOINT_60_LEARNING);
static SCPHD_MEMORY(hypotheses_memory, SCPHD_SIZE_JOINT_24_HYPOTHESES);
static SCPHD_MEMORY(sideways_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(car_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(car_mixture_memory, SCPHD_SIZE_MIXTURE_INFORMED_4_MOVING);
static SCPHD_MEMORY(strict_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(water_memory, SCPHD_SIZE_WATER_INFORMED_16);
static SCPHD_MEMORY(sonar_memory, SCPHD_SIZE_SONAR_64);
static SCPHD_MEMORY(about_memory, SCPHD_SIZE_DESCRIPTION);

/* The filters in the plane, in the order of their states in the file; between the third and the fourth is the diver. */
enum { BLIND, INFORMED, JOINT, MOVERS, ARCHIVE, LEARNING, HYPOTHESES, SIDEWAYS, CAR, CAR_MIXTURE, STRICT, PLANAR };
static scphd_slam *planar[PLANAR];
static scphd_water *water;
static scphd_sonar_detector *sonar;
static scphd_description *about;

enum { LIDAR, RADAR, CAMERA };

static void set(uint32_t setting, size_t sensor, float number) {
    OK(scphd_description_set(about, setting, sensor, number, NULL));
}

static void describe_polar(size_t sensor, float range_m, float range_sigma_m, float bearing_sigma_rad) {
    set(SCPHD_SENSOR_MODEL, sensor, SCPHD_SENSOR_MODEL_RANGE_BEARING);
    set(SCPHD_SENSOR_RANGE_MAX_M, sensor, range_m);
    set(SCPHD_SENSOR_PROBABILITY_NEAR, sensor, 0.85f);
    set(SCPHD_SENSOR_PROBABILITY_FAR, sensor, 0.85f);
    set(SCPHD_SENSOR_RANGE_SIGMA_M, sensor, range_sigma_m);
    set(SCPHD_SENSOR_BEARING_SIGMA_RAD, sensor, bearing_sigma_rad);
    set(SCPHD_SENSOR_RANGE_EDGE_M, sensor, 3.0f * range_sigma_m);
    set(SCPHD_SENSOR_BEARING_EDGE_RAD, sensor, 3.0f * bearing_sigma_rad);
}

static void describe_sensors(void) {
    describe_polar(LIDAR, 12.0f, 0.05f, 0.01f);
    set(SCPHD_SENSOR_BEARING_HALF_WIDTH_RAD, LIDAR, 2.0f);
    set(SCPHD_SENSOR_CLUTTER_PER_SCAN, LIDAR, 2.0f);
    set(SCPHD_SENSOR_BIRTHS_STILL, LIDAR, 0.002f);
    set(SCPHD_SENSOR_BIRTHS_MOVING, LIDAR, 0.001f);
    set(SCPHD_SENSOR_FORWARD_M, LIDAR, 0.22f);
    set(SCPHD_SENSOR_YAW_RAD, LIDAR, 0.5f);

    describe_polar(RADAR, 20.0f, 0.2f, 0.03f);
    set(SCPHD_SENSOR_RANGE_SIGMA_RATIO, RADAR, 0.02f);
    set(SCPHD_SENSOR_BEARING_HALF_WIDTH_RAD, RADAR, 0.8f);
    set(SCPHD_SENSOR_BIRTHS_STILL, RADAR, 0.003f);
    set(SCPHD_SENSOR_FORWARD_M, RADAR, -0.3f);
    set(SCPHD_SENSOR_LEFT_M, RADAR, 0.1f);
    set(SCPHD_SENSOR_YAW_RAD, RADAR, 3.0f);
}

static void describe_camera(void) {
    set(SCPHD_SENSOR_MODEL, CAMERA, SCPHD_SENSOR_MODEL_BEARING);
    set(SCPHD_SENSOR_RANGE_MAX_M, CAMERA, 12.0f);
    set(SCPHD_SENSOR_PROBABILITY_NEAR, CAMERA, 0.85f);
    set(SCPHD_SENSOR_PROBABILITY_FAR, CAMERA, 0.85f);
    set(SCPHD_SENSOR_BEARING_SIGMA_RAD, CAMERA, 0.02f);
    set(SCPHD_SENSOR_BEARING_HALF_WIDTH_RAD, CAMERA, 2.0f);
    set(SCPHD_SENSOR_BIRTHS_NEAREST_M, CAMERA, 2.0f);
    set(SCPHD_SENSOR_BIRTHS_FARTHEST_M, CAMERA, 12.0f);
    set(SCPHD_SENSOR_BIRTHS_RINGS, CAMERA, 3);
    set(SCPHD_SENSOR_BIRTHS_SECTORS, CAMERA, 16);
    set(SCPHD_SENSOR_BIRTHS_WEIGHT, CAMERA, 0.0005f);
    set(SCPHD_SENSOR_FORWARD_M, CAMERA, 0.22f);
    set(SCPHD_SENSOR_YAW_RAD, CAMERA, 0.5f);
}

static void start_joint_40(void *memory, size_t bytes, int place) {
    OK(scphd_start_joint_40(SCPHD_ABI_VERSION, memory, bytes, about, NULL, &planar[place]));
    OK(scphd_services_joint_40(planar[place]));
    OK(scphd_slam_reset(planar[place], about));
}

static void start_filters(void) {
    OK(scphd_description_start(SCPHD_ABI_VERSION, about_memory, sizeof about_memory, &about));
    describe_sensors();
    set(SCPHD_POSITION, 0, SCPHD_POSITION_YES);
    set(SCPHD_POSITION_SIGMA, 0, 0.3f);
    set(SCPHD_POSITION_GATE, 0, 25.0f);
    set(SCPHD_POSITION_FORWARD_M, 0, -0.5f);
    set(SCPHD_POSITION_LEFT_M, 0, 0.1f);
    set(SCPHD_HEADING, 0, SCPHD_HEADING_YES);
    set(SCPHD_HEADING_SIGMA, 0, 0.05f);
    set(SCPHD_START_X_M, 0, 5.0f);
    set(SCPHD_START_HEADING_RAD, 0, 1.5f);
    start_joint_40(joint_memory, sizeof joint_memory, JOINT);

    set(SCPHD_JOINT_MOVERS, 0, SCPHD_JOINT_MOVERS_YES);
    OK(scphd_start_joint_60_movers(SCPHD_ABI_VERSION, movers_memory, sizeof movers_memory, about, NULL, &planar[MOVERS]));
    OK(scphd_services_joint_60_movers(planar[MOVERS]));
    OK(scphd_slam_reset(planar[MOVERS], about));

    set(SCPHD_JOINT_ARCHIVE, 0, SCPHD_JOINT_ARCHIVE_YES);
    set(SCPHD_JOINT_ARCHIVE_REACH_M, 0, 12.0f);
    OK(scphd_start_joint_40_archive(SCPHD_ABI_VERSION, archive_memory, sizeof archive_memory, about, NULL, &planar[ARCHIVE]));
    OK(scphd_services_joint_40_archive(planar[ARCHIVE]));
    OK(scphd_slam_reset(planar[ARCHIVE], about));

    set(SCPHD_JOINT_MOVERS, 0, SCPHD_JOINT_MOVERS_NO);
    set(SCPHD_JOINT_ARCHIVE, 0, SCPHD_JOINT_ARCHIVE_NO);
    set(SCPHD_JOINT_ODOMETRY, 0, SCPHD_JOINT_ODOMETRY_YES);
    OK(scphd_start_joint_60_learning(SCPHD_ABI_VERSION, learning_memory, sizeof learning_memory, about, NULL, &planar[LEARNING]));
    OK(scphd_services_joint_60_learning(planar[LEARNING]));
    OK(scphd_slam_reset(planar[LEARNING], about));

    set(SCPHD_JOINT_ODOMETRY, 0, SCPHD_JOINT_ODOMETRY_NO);
    set(SCPHD_JOINT_MOVERS, 0, SCPHD_JOINT_MOVERS_YES);
    set(SCPHD_JOINT_HYPOTHESES, 0, SCPHD_JOINT_HYPOTHESES_YES);
    OK(scphd_start_joint_24_hypotheses(SCPHD_ABI_VERSION, hypotheses_memory, sizeof hypotheses_memory, about, NULL, &planar[HYPOTHESES]));
    OK(scphd_services_joint_24_hypotheses(planar[HYPOTHESES]));
    OK(scphd_slam_reset(planar[HYPOTHESES], about));

    set(SCPHD_JOINT_MOVERS, 0, SCPHD_JOINT_MOVERS_NO);
    set(SCPHD_JOINT_HYPOTHESES, 0, SCPHD_JOINT_HYPOTHESES_NO);
    set(SCPHD_VEHICLE_KIND, 0, SCPHD_VEHICLE_KIND_HOLONOMIC);
    start_joint_40(sideways_memory, sizeof sideways_memory, SIDEWAYS);

    set(SCPHD_VEHICLE_KIND, 0, SCPHD_VEHICLE_KIND_UNICYCLE_EULER);
    set(SCPHD_JOINT_LEAST_EXISTENCE, 0, 0.01f);
    set(SCPHD_JOINT_LEAST_TENTATIVE, 0, 0.1f);
    start_joint_40(strict_memory, sizeof strict_memory, STRICT);

    /* Another filter than before has its defaults. */
    set(SCPHD_FILTER, 0, SCPHD_FILTER_MIXTURE);
    set(SCPHD_FILTER, 0, SCPHD_FILTER_JOINT);
    set(SCPHD_VEHICLE_KIND, 0, SCPHD_VEHICLE_KIND_ACKERMANN);
    set(SCPHD_VEHICLE_WHEELBASE_M, 0, 2.5f);
    set(SCPHD_VEHICLE_ENCODER_OFFSET_M, 0, 0.5f);
    set(SCPHD_VEHICLE_SENSOR_FORWARD_M, 0, 3.0f);
    set(SCPHD_VEHICLE_SENSOR_LEFT_M, 0, 0.25f);
    start_joint_40(car_memory, sizeof car_memory, CAR);

    set(SCPHD_FILTER, 0, SCPHD_FILTER_MIXTURE);
    set(SCPHD_START_SEED, 0, 10);
    OK(scphd_start_mixture_informed_4_moving(SCPHD_ABI_VERSION, car_mixture_memory, sizeof car_mixture_memory, about, NULL, &planar[CAR_MIXTURE]));
    OK(scphd_services_mixture_informed_4_moving(planar[CAR_MIXTURE]));
    OK(scphd_slam_reset(planar[CAR_MIXTURE], about));

    set(SCPHD_VEHICLE_KIND, 0, SCPHD_VEHICLE_KIND_UNICYCLE);
    set(SCPHD_MIXTURE_PRUNE_WEIGHT, 0, 1e-3f);
    set(SCPHD_START_SEED, 0, 8);
    OK(scphd_start_mixture_informed_4_moving(SCPHD_ABI_VERSION, informed_memory, sizeof informed_memory, about, NULL, &planar[INFORMED]));
    OK(scphd_services_mixture_informed_4_moving(planar[INFORMED]));
    OK(scphd_slam_reset(planar[INFORMED], about));

    set(SCPHD_FILTER, 0, SCPHD_FILTER_JOINT);
    set(SCPHD_FILTER, 0, SCPHD_FILTER_MIXTURE);
    set(SCPHD_MIXTURE_PARTICLES, 0, 16);
    const scphd_water_config dive = {sizeof dive, 0.1f, 1.0f};
    OK(scphd_water_start(SCPHD_ABI_VERSION, water_memory, sizeof water_memory, about, &dive, NULL, &water));
    OK(scphd_water_reset(water, 2.0f, 0.0f, -1.0f, 1.5f, 9));

    describe_camera();
    set(SCPHD_MIXTURE_PROPOSAL, 0, SCPHD_MIXTURE_PROPOSAL_BLIND);
    set(SCPHD_MIXTURE_PARTICLES, 0, 32);
    set(SCPHD_MIXTURE_SAMPLES, 0, 2);
    set(SCPHD_START_SEED, 0, 7);
    OK(scphd_start_mixture_32x2(SCPHD_ABI_VERSION, blind_memory, sizeof blind_memory, about, NULL, &planar[BLIND]));
    OK(scphd_services_mixture_32x2(planar[BLIND]));
    OK(scphd_slam_reset(planar[BLIND], about));

    scphd_sonar_config spherical;
    spherical.struct_size = sizeof spherical;
    OK(scphd_sonar_defaults(&spherical, 8.0f, 0.9f));
    spherical.range_sigma_m = 0.05f;
    spherical.bearing_sigma_rad = 0.02f;
    spherical.elevation_sigma_rad = 0.02f;
    spherical.range_edge_m = 0.15f;
    spherical.births_still = 0.001f;
    OK(scphd_sonar_start(SCPHD_ABI_VERSION, sonar_memory, sizeof sonar_memory, &spherical, NULL, &sonar));
}

static void take(char letter, const float *numbers, size_t count) {
    const scphd_range_bearing *polar = (const scphd_range_bearing *)numbers;
    const scphd_fix depth = {sizeof depth, 0.1f, 0.0f};
    scphd_water_control control;
    switch (letter) {
    case 'p':
        for (int each = 0; each < PLANAR; each++) {
            /* The holonomic vehicle also moves to the left, and a car has a steering angle. */
            const float left = each == SIDEWAYS ? 0.25f * numbers[1] : 0.0f;
            const float turn = each == CAR || each == CAR_MIXTURE ? 0.5f * numbers[1] : numbers[1];
            OK(scphd_slam_predict(planar[each], numbers[0], left, turn, numbers[2], NULL));
        }
        break;
    case 'l':
    case 'r':
        for (int each = 0; each < PLANAR; each++) {
            OK(scphd_slam_scan_range_bearing(planar[each], letter == 'l' ? LIDAR : RADAR, polar, count / 2, NULL));
        }
        break;
    case 'c':
        OK(scphd_slam_scan_bearing(planar[BLIND], CAMERA, numbers, count, NULL));
        break;
    case 'g':
        for (int each = 0; each < PLANAR; each++) {
            OK(scphd_slam_observe_position(planar[each], numbers[0], numbers[1], NULL));
        }
        break;
    case 'h':
        for (int each = 0; each < PLANAR; each++) {
            OK(scphd_slam_observe_heading(planar[each], numbers[0], NULL));
        }
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
        OK(scphd_water_observe_height(water, &depth, numbers[0], NULL));
        break;
    default:
        HOLDS(!"a letter that is known");
    }
}

enum { STATES = PLANAR + 1 };

static void compare(const uint64_t wanted[STATES], int scan) {
    for (int each = 0; each < PLANAR; each++) {
        uint64_t got = 0;
        const int place = each <= JOINT ? each : each + 1;
        OK(scphd_slam_digest(planar[each], &got));
        if (got != wanted[place]) {
            printf("scan %d, state %d: %016" PRIx64 "\n", scan, place, got);
            failures++;
        }
    }
    uint64_t dive = 0;
    OK(scphd_water_digest(water, &dive));
    if (dive != wanted[JOINT + 1]) {
        printf("scan %d, the diver: %016" PRIx64 "\n", scan, dive);
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
    int scans = 0;
    char letter;
    unsigned length;
    while (failures == 0 && scans < REPLAY_SCANS && fscanf(file, " %c %u", &letter, &length) == 2) {
        if (letter == '=') {
            uint64_t wanted[STATES];
            for (unsigned at = 0; at < STATES; at++) {
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
