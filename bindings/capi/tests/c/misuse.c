/* Whatever C gets wrong is answered by a status, and changes nothing. */
#include "check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static SCPHD_MEMORY(memory, SCPHD_SIZE_PLANE_INFORMED_4);
static SCPHD_MEMORY(copy, SCPHD_SIZE_PLANE_INFORMED_4);
static SCPHD_MEMORY(joint_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(eye_memory, SCPHD_SIZE_RANGE_BEARING_32);

static scphd_plane_config robot(void) {
    scphd_plane_config config;
    config.struct_size = sizeof config;
    OK(scphd_plane_informed(&config, 4));
    config.vehicle.speed_sigma_mps = 0.1f;
    config.vehicle.turn_sigma = 0.02f;
    return config;
}

static scphd_range_bearing_config eye_of(float sigma) {
    scphd_range_bearing_config config;
    config.struct_size = sizeof config;
    OK(scphd_range_bearing_defaults(&config, 10.0f, 0.9f));
    config.range_sigma_m = sigma;
    config.bearing_sigma_rad = sigma;
    return config;
}

static scphd_status start(void *at, size_t size, const scphd_plane_config *config, scphd_plane **filter) {
    return scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, at, size, config, NULL, filter);
}

static void starting(void) {
    scphd_plane *filter = NULL;
    scphd_plane_config config = robot();
    unsigned char *bytes = (unsigned char *)memory;

    IS(start(NULL, sizeof memory, &config, &filter), SCPHD_STATUS_NULL_POINTER);
    IS(start(memory, sizeof memory, NULL, &filter), SCPHD_STATUS_NULL_POINTER);
    IS(start(memory, sizeof memory, &config, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(start(bytes + 4, sizeof memory - 4, &config, &filter), SCPHD_STATUS_MISALIGNED);
    IS(start(memory, sizeof memory - 1, &config, &filter), SCPHD_STATUS_MEMORY_TOO_SMALL);
    IS(start(memory, 0, &config, &filter), SCPHD_STATUS_MEMORY_TOO_SMALL);
    IS(scphd_plane_start(SCPHD_ABI_VERSION + 1, SCPHD_SET_PLANE_INFORMED_4, memory, sizeof memory, &config, NULL, &filter),
       SCPHD_STATUS_WRONG_VERSION);
    IS(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, memory, sizeof memory, &config, NULL, &filter),
       SCPHD_STATUS_UNKNOWN_SET);
    IS(scphd_plane_start(SCPHD_ABI_VERSION, 199, memory, sizeof memory, &config, NULL, &filter), SCPHD_STATUS_UNKNOWN_SET);
    HOLDS(scphd_abi_version() == SCPHD_ABI_VERSION);
    HOLDS(scphd_memory_alignment() == SCPHD_ALIGNMENT && scphd_memory_size(SCPHD_SET_PLANE_INFORMED_4) == sizeof memory);

    scphd_plane_config other = config;
    other.struct_size = sizeof other + 4;
    IS(start(memory, sizeof memory, &other, &filter), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    IS(scphd_plane_blind(&other, 1, 1), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    other = config;
    other.tuning.particles = 5;
    IS(start(memory, sizeof memory, &other, &filter), SCPHD_STATUS_TOO_MANY_PARTICLES);
    other = config;
    other.tuning.prune_weight = NAN;
    scphd_reason reason;
    reason.struct_size = sizeof reason;
    IS(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, memory, sizeof memory, &other, &reason, &filter),
       SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(strcmp(reason.text, "prune_weight must be above 0 and below 1") == 0);
    other = config;
    other.vehicle.kind = 77;
    IS(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, memory, sizeof memory, &other, &reason, &filter),
       SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(strncmp(reason.text, "vehicle.kind", 12) == 0);
    reason.struct_size = 0;
    IS(scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, memory, sizeof memory, &config, &reason, &filter),
       SCPHD_STATUS_WRONG_STRUCT_SIZE);
    HOLDS(filter == NULL);

    OK(start(memory, sizeof memory, &config, &filter));
    HOLDS(filter != NULL);
    scphd_plane *second = filter;
    IS(start(memory, sizeof memory, &config, &second), SCPHD_STATUS_ALREADY_STARTED);
    HOLDS(second == NULL);
    OK(scphd_release(memory, sizeof memory));
    IS(scphd_plane_reset(filter, 0.0f, 0.0f, 0.0f, 1), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_release(NULL, sizeof memory), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_release(memory, 4), SCPHD_STATUS_MEMORY_TOO_SMALL);
}

static void handles(void) {
    scphd_plane *filter = NULL;
    scphd_range_bearing_detector *eye = NULL;
    scphd_plane_config config = robot();
    scphd_range_bearing_config seeing = eye_of(0.0f);
    scphd_range_bearing seen[64] = {{5.0f, 0.1f}, {4.0f, -1.0f}};
    uint64_t before = 0, after = 1;

    IS(scphd_plane_predict_robot(NULL, 1.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_plane_predict_robot((scphd_plane *)(void *)memory, 1.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_plane_predict_robot((scphd_plane *)(void *)((unsigned char *)memory + 1), 1.0f, 0.0f, 0.1f, NULL),
       SCPHD_STATUS_MISALIGNED);
    OK(start(memory, sizeof memory, &config, &filter));
    scphd_reason reason;
    reason.struct_size = sizeof reason;
    IS(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, eye_memory, sizeof eye_memory, &seeing, &reason,
                                 &eye),
       SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(strncmp(reason.text, "range_sigma_m must be", 21) == 0);
    seeing = eye_of(0.1f);
    OK(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, eye_memory, sizeof eye_memory, &seeing, &reason,
                                 &eye));

    /* Before the first pose. */
    scphd_plane_pose pose;
    pose.struct_size = sizeof pose;
    IS(scphd_plane_predict_robot(filter, 1.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NOT_RESET);
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, 2, NULL), SCPHD_STATUS_NOT_RESET);
    IS(scphd_plane_estimate_pose(filter, &pose), SCPHD_STATUS_NOT_RESET);
    IS(scphd_plane_reset(filter, NAN, 0.0f, 0.0f, 1), SCPHD_STATUS_BAD_POSE);
    OK(scphd_plane_reset(filter, 0.0f, 0.0f, 0.0f, 1));
    OK(scphd_plane_scan_range_bearing(filter, eye, seen, 2, NULL));

    /* A detector is no filter, and a filter no detector. */
    IS(scphd_plane_scan_range_bearing((scphd_plane *)(void *)eye, eye, seen, 2, NULL), SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_plane_scan_range_bearing(filter, (scphd_range_bearing_detector *)(void *)filter, seen, 2, NULL),
       SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_joint_reset((scphd_joint *)(void *)filter, 0.0f, 0.0f, 0.0f), SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_plane_scan_bearing(filter, (scphd_bearing_detector *)(void *)eye, &seen[0].range_m, 2, NULL),
       SCPHD_STATUS_WRONG_MEMORY);

    OK(scphd_plane_digest(filter, &before));
    IS(scphd_plane_digest(filter, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_plane_scan_range_bearing(filter, eye, NULL, 2, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_plane_scan_range_bearing(filter, eye, (const scphd_range_bearing *)(const void *)((const char *)seen + 2), 1, NULL),
       SCPHD_STATUS_MISALIGNED);
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, SIZE_MAX / 2, NULL), SCPHD_STATUS_ARRAY_TOO_LONG);
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, 33, NULL), SCPHD_STATUS_TOO_MANY_MEASUREMENTS);
    seen[1].bearing_rad = NAN;
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, 2, NULL), SCPHD_STATUS_BAD_MEASUREMENT);
    scphd_scan_report report;
    report.struct_size = 3;
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, 1, &report), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    pose.struct_size = 0;
    IS(scphd_plane_estimate_pose(filter, &pose), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    scphd_fix fix = {sizeof fix, NAN, 0.0f, 0.0f, 0.0f};
    IS(scphd_plane_observe_heading(filter, &fix, 0.0f, NULL), SCPHD_STATUS_OUT_OF_RANGE);
    fix.sigma = 0.1f;
    IS(scphd_plane_observe_heading(filter, &fix, INFINITY, NULL), SCPHD_STATUS_BAD_MEASUREMENT);
    IS(scphd_plane_observe_position(filter, NULL, 0.0f, 0.0f, NULL), SCPHD_STATUS_NULL_POINTER);
    OK(scphd_plane_digest(filter, &after));
    HOLDS(before == after);

    /* What is refused of a prediction is told of by the next report. */
    IS(scphd_plane_predict_robot(filter, NAN, 0.0f, 0.1f, NULL), SCPHD_STATUS_BAD_CONTROL);
    IS(scphd_plane_predict_robot(filter, 1.0f, 0.0f, -0.1f, NULL), SCPHD_STATUS_BAD_TIME_STEP);
    IS(scphd_plane_predict_robot(filter, 400.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_IMPLAUSIBLE);
    IS(scphd_plane_predict_car(filter, 1.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_BAD_CONTROL);
    IS(scphd_plane_predict_holonomic(filter, 1.0f, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_BAD_CONTROL);
    report.struct_size = sizeof report;
    OK(scphd_plane_scan_range_bearing(filter, eye, seen, 1, &report));
    HOLDS(report.refused == 5 && (report.health & SCPHD_HEALTH_PREDICTION_REFUSED) != 0);
    OK(scphd_plane_scan_range_bearing(filter, eye, NULL, 0, &report));

    /* Features that move need a set with room for them. */
    seeing.births_moving = 0.01f;
    OK(scphd_release(eye_memory, sizeof eye_memory));
    OK(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, eye_memory, sizeof eye_memory, &seeing, NULL, &eye));
    IS(scphd_plane_scan_range_bearing(filter, eye, seen, 1, NULL), SCPHD_STATUS_NO_ROOM_FOR_MOVING);
}

static void resuming(void) {
    scphd_plane *filter = (scphd_plane *)(void *)memory, *again = NULL;
    scphd_plane_config config = robot();
    uint64_t before = 0, after = 1;
    scphd_range_bearing_config seeing = eye_of(0.1f);
    scphd_range_bearing_detector *eye = NULL;
    OK(scphd_release(eye_memory, sizeof eye_memory));
    OK(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, eye_memory, sizeof eye_memory, &seeing, NULL, &eye));
    const scphd_range_bearing seen = {5.0f, 0.1f};
    for (int step = 0; step < 20; step++) {
        OK(scphd_plane_predict_robot(filter, 0.0f, 0.0f, 0.1f, NULL));
        OK(scphd_plane_scan_range_bearing(filter, eye, &seen, 1, NULL));
    }
    OK(scphd_plane_digest(filter, &before));

    /* A copy elsewhere is no filter until it is resumed. */
    memcpy(copy, memory, sizeof copy);
    IS(scphd_plane_digest((scphd_plane *)(void *)copy, &after), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_plane_resume(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_32X2, copy, sizeof copy, &config, NULL, &again),
       SCPHD_STATUS_MEMORY_TOO_SMALL);
    scphd_plane_config other = config;
    other.tuning.particles = 3;
    IS(scphd_plane_resume(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, copy, sizeof copy, &other, NULL, &again),
       SCPHD_STATUS_OTHER_CONFIGURATION);
    IS(start(copy, sizeof copy, &config, &again), SCPHD_STATUS_ALREADY_STARTED);
    OK(scphd_plane_resume(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, copy, sizeof copy, &config, NULL, &again));
    OK(scphd_plane_digest(again, &after));
    HOLDS(before == after);

    /* Both go on alike. */
    OK(scphd_plane_predict_robot(filter, 1.0f, 0.1f, 0.1f, NULL));
    OK(scphd_plane_predict_robot(again, 1.0f, 0.1f, 0.1f, NULL));
    OK(scphd_plane_scan_range_bearing(filter, eye, &seen, 1, NULL));
    OK(scphd_plane_scan_range_bearing(again, eye, &seen, 1, NULL));
    OK(scphd_plane_digest(filter, &before));
    OK(scphd_plane_digest(again, &after));
    HOLDS(before == after);

    /* A map in an array that is too small. */
    scphd_map map;
    map.struct_size = sizeof map;
    scphd_feature features[4];
    OK(scphd_plane_estimate_map(filter, features, 4, &map));
    HOLDS(map.features == 1 && map.left_out == 0 && fabsf(features[0].x_m - 5.0f) < 0.2f && features[0].weight > 0.5f);
    OK(scphd_plane_estimate_map(filter, NULL, 0, &map));
    HOLDS(map.features == 0 && map.left_out == 1);
    IS(scphd_plane_estimate_map(filter, NULL, 4, &map), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_plane_estimate_map(filter, features, 4, NULL), SCPHD_STATUS_NULL_POINTER);
    scphd_mover mover;
    OK(scphd_plane_estimate_movers(filter, &mover, 1, &map));
    HOLDS(map.features == 0 && map.left_out == 0);

    /* Nothing to resume. */
    OK(scphd_release(copy, sizeof copy));
    IS(scphd_plane_resume(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, copy, sizeof copy, &config, NULL, &again),
       SCPHD_STATUS_NOT_STARTED);

    scphd_joint_config joint;
    joint.struct_size = sizeof joint;
    OK(scphd_joint_defaults(&joint));
    scphd_joint *map_of_all = NULL;
    IS(scphd_joint_resume(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, joint_memory, sizeof joint_memory, &joint, NULL, &map_of_all),
       SCPHD_STATUS_NOT_STARTED);
    OK(scphd_joint_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, joint_memory, sizeof joint_memory, &joint, NULL, &map_of_all));
    OK(scphd_joint_reset(map_of_all, 0.0f, 0.0f, 0.0f));
    for (int step = 0; step < 20; step++) {
        OK(scphd_joint_scan_range_bearing(map_of_all, eye, &seen, 1, NULL));
    }
    OK(scphd_joint_estimate_map(map_of_all, features, 4, &map));
    HOLDS(map.features == 1 && fabsf(features[0].x_m - 5.0f) < 0.2f);
    OK(scphd_joint_resume(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, joint_memory, sizeof joint_memory, &joint, NULL, &map_of_all));
    OK(scphd_joint_estimate_map(map_of_all, NULL, 0, &map));
    HOLDS(map.left_out == 1);

    /* A vehicle that moves sideways too. */
    joint.vehicle.kind = SCPHD_VEHICLE_HOLONOMIC;
    OK(scphd_release(joint_memory, sizeof joint_memory));
    OK(scphd_joint_start(SCPHD_ABI_VERSION, SCPHD_SET_JOINT_40, joint_memory, sizeof joint_memory, &joint, NULL, &map_of_all));
    OK(scphd_joint_reset(map_of_all, 0.0f, 0.0f, 0.0f));
    OK(scphd_joint_predict_holonomic(map_of_all, 1.0f, 2.0f, 0.0f, 0.5f, NULL));
    IS(scphd_joint_predict_robot(map_of_all, 1.0f, 0.0f, 0.5f, NULL), SCPHD_STATUS_BAD_CONTROL);
    scphd_plane_pose sideways;
    sideways.struct_size = sizeof sideways;
    OK(scphd_joint_estimate_pose(map_of_all, &sideways));
    HOLDS(fabsf(sideways.x_m - 0.5f) < 1e-5f && fabsf(sideways.y_m - 1.0f) < 1e-5f);
}

/* A set for each filter, in memory that ends where the set does: what writes beyond is seen by valgrind. */
static void to_the_last_byte(void) {
    scphd_plane_config config = robot();
    scphd_plane *filter = NULL;
    void *exact = calloc(1, SCPHD_SIZE_PLANE_INFORMED_4);
    HOLDS(exact != NULL);
    OK(start(exact, SCPHD_SIZE_PLANE_INFORMED_4, &config, &filter));
    OK(scphd_plane_reset(filter, 0.0f, 0.0f, 0.0f, 1));
    OK(scphd_plane_predict_robot(filter, 1.0f, 0.0f, 0.1f, NULL));
    free(exact);
}

static void texts(void) {
    for (int status = -5; status < 200; status++) {
        HOLDS(scphd_error_text(status)[0] != '\0');
    }
    HOLDS(strcmp(scphd_health_text(0), "GOOD") == 0);
    HOLDS(strcmp(scphd_health_text(SCPHD_HEALTH_LOST | SCPHD_HEALTH_CLUTTER_HIGH), "LOST") == 0);
    HOLDS(strncmp(scphd_health_text(1u << 31), "not", 3) == 0);
}

int main(void) {
    starting();
    handles();
    resuming();
    to_the_last_byte();
    texts();
    printf("%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
