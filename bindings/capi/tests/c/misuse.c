/* Whatever C gets wrong is answered by a status, and changes nothing. */
#include "check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static SCPHD_MEMORY(memory, SCPHD_SIZE_MIXTURE_INFORMED_4);
static SCPHD_MEMORY(copy, SCPHD_SIZE_MIXTURE_INFORMED_4);
static SCPHD_MEMORY(joint_memory, SCPHD_SIZE_JOINT_40);
static SCPHD_MEMORY(about_memory, SCPHD_SIZE_DESCRIPTION);
static SCPHD_MEMORY(sonar_memory, SCPHD_SIZE_SONAR_64);

static scphd_description *about;
static scphd_reason reason;

static scphd_status set(uint32_t setting, float number) {
    return scphd_description_set(about, setting, 0, number, &reason);
}

static scphd_status start(void *at, size_t size, scphd_description *description, scphd_slam **slam) {
    return scphd_start_mixture_informed_4(SCPHD_ABI_VERSION, at, size, description, &reason, slam);
}

static void describing(void) {
    IS(scphd_description_start(SCPHD_ABI_VERSION + 1, about_memory, sizeof about_memory, &about), SCPHD_STATUS_WRONG_VERSION);
    IS(scphd_description_start(SCPHD_ABI_VERSION, about_memory, 8, &about), SCPHD_STATUS_MEMORY_TOO_SMALL);
    OK(scphd_description_start(SCPHD_ABI_VERSION, about_memory, sizeof about_memory, &about));
    reason.struct_size = 0;
    IS(set(SCPHD_FILTER, SCPHD_FILTER_MIXTURE), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    reason.struct_size = sizeof reason;
    OK(set(SCPHD_FILTER, SCPHD_FILTER_MIXTURE));
    OK(set(SCPHD_NOISE_SPEED_SIGMA_MPS, 0.1f));
    OK(set(SCPHD_NOISE_TURN_SIGMA, 0.02f));
    OK(set(SCPHD_SENSOR_MODEL, SCPHD_SENSOR_MODEL_RANGE_BEARING));
    OK(set(SCPHD_SENSOR_RANGE_MAX_M, 10.0f));
    OK(set(SCPHD_SENSOR_RANGE_SIGMA_M, 0.1f));
    OK(set(SCPHD_SENSOR_BEARING_SIGMA_RAD, 0.1f));
    OK(set(SCPHD_HEADING, SCPHD_HEADING_YES));
    OK(set(SCPHD_HEADING_SIGMA, 0.1f));

    /* What is wrong is named. */
    IS(set(SCPHD_MIXTURE_PRUNE_WEIGHT, NAN), SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(reason.setting == SCPHD_MIXTURE_PRUNE_WEIGHT && reason.text[0] == '\0');
    HOLDS(strcmp(scphd_setting_name(reason.setting), "mixture.prune_weight") == 0);
    HOLDS(strcmp(scphd_setting_range(reason.setting), "above 0 and below 1") == 0);
    IS(scphd_description_set(about, SCPHD_SENSOR_RANGE_MAX_M, 3, -1.0f, &reason), SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(reason.setting == SCPHD_SENSOR_RANGE_MAX_M && reason.sensor == 3);
    IS(set(SCPHD_VEHICLE_KIND, 77), SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(reason.setting == SCPHD_VEHICLE_KIND && reason.sensor == 0);
    IS(set(SCPHD_VEHICLE_KIND, 0.5f), SCPHD_STATUS_OUT_OF_RANGE);
    IS(set(SCPHD_JOINT_GATE, 1.0f), SCPHD_STATUS_OUT_OF_RANGE);
    IS(set(0, 1.0f), SCPHD_STATUS_UNKNOWN_SETTING);
    HOLDS(reason.setting == 0);
    IS(set(SCPHD_SENSOR_YAW_RAD + 1, 1.0f), SCPHD_STATUS_UNKNOWN_SETTING);
    IS(set(UINT32_MAX, 1.0f), SCPHD_STATUS_UNKNOWN_SETTING);
    HOLDS(strcmp(scphd_setting_name(0), "no setting") == 0 && strcmp(scphd_setting_range(UINT32_MAX), "no setting") == 0);
    float number = 0.0f;
    OK(scphd_description_get(about, SCPHD_MIXTURE_PARTICLES, 0, &number));
    HOLDS(number == 4.0f);
    IS(scphd_description_get(about, SCPHD_JOINT_GATE, 0, &number), SCPHD_STATUS_NOT_DESCRIBED);
    IS(scphd_description_get(about, SCPHD_MIXTURE_PARTICLES, 0, NULL), SCPHD_STATUS_NULL_POINTER);
}

static void starting(void) {
    scphd_slam *slam = NULL;
    unsigned char *bytes = (unsigned char *)memory;

    IS(start(NULL, sizeof memory, about, &slam), SCPHD_STATUS_NULL_POINTER);
    IS(start(memory, sizeof memory, NULL, &slam), SCPHD_STATUS_NULL_POINTER);
    IS(start(memory, sizeof memory, about, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(start(memory, sizeof memory, (scphd_description *)(void *)copy, &slam), SCPHD_STATUS_NOT_STARTED);
    IS(start(bytes + 4, sizeof memory - 4, about, &slam), SCPHD_STATUS_MISALIGNED);
    IS(start(memory, sizeof memory - 1, about, &slam), SCPHD_STATUS_MEMORY_TOO_SMALL);
    IS(start(memory, 0, about, &slam), SCPHD_STATUS_MEMORY_TOO_SMALL);
    IS(scphd_start_mixture_informed_4(SCPHD_ABI_VERSION + 1, memory, sizeof memory, about, NULL, &slam),
       SCPHD_STATUS_WRONG_VERSION);
    HOLDS(scphd_abi_version() == SCPHD_ABI_VERSION);
    HOLDS(scphd_memory_alignment() == SCPHD_ALIGNMENT);

    /* A set has what its filter is described with, and nothing else. */
    IS(scphd_start_joint_40(SCPHD_ABI_VERSION, joint_memory, sizeof joint_memory, about, &reason, &slam), SCPHD_STATUS_NO_ROOM);
    HOLDS(reason.setting == SCPHD_FILTER);
    OK(set(SCPHD_MIXTURE_PARTICLES, 5));
    IS(start(memory, sizeof memory, about, &slam), SCPHD_STATUS_TOO_MANY_PARTICLES);
    OK(set(SCPHD_MIXTURE_PARTICLES, 4));
    OK(set(SCPHD_SENSOR_BIRTHS_MOVING, 0.01f));
    IS(start(memory, sizeof memory, about, &slam), SCPHD_STATUS_NO_ROOM_FOR_MOVING);
    OK(set(SCPHD_SENSOR_BIRTHS_MOVING, 0.0f));
    reason.struct_size = 0;
    IS(start(memory, sizeof memory, about, &slam), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    reason.struct_size = sizeof reason;
    HOLDS(slam == NULL);

    OK(start(memory, sizeof memory, about, &slam));
    HOLDS(slam != NULL);
    scphd_slam *second = slam;
    IS(start(memory, sizeof memory, about, &second), SCPHD_STATUS_ALREADY_STARTED);
    HOLDS(second == NULL);
    OK(scphd_release(memory, sizeof memory));
    IS(scphd_slam_reset(slam, about), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_release(NULL, sizeof memory), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_release(memory, 4), SCPHD_STATUS_MEMORY_TOO_SMALL);
}

static void handles(void) {
    scphd_slam *slam = NULL;
    scphd_range_bearing seen[66] = {{5.0f, 0.1f}, {4.0f, -1.0f}};
    uint64_t before = 0, after = 1;

    IS(scphd_slam_predict(NULL, 1.0f, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_slam_predict((scphd_slam *)(void *)memory, 1.0f, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_slam_predict((scphd_slam *)(void *)((unsigned char *)memory + 1), 1.0f, 0.0f, 0.0f, 0.1f, NULL),
       SCPHD_STATUS_MISALIGNED);
    OK(start(memory, sizeof memory, about, &slam));
    scphd_sonar_config hearing;
    scphd_sonar_detector *sonar = NULL;
    hearing.struct_size = sizeof hearing;
    OK(scphd_sonar_defaults(&hearing, 8.0f, 0.9f));
    IS(scphd_sonar_start(SCPHD_ABI_VERSION, sonar_memory, sizeof sonar_memory, &hearing, &reason, &sonar),
       SCPHD_STATUS_OUT_OF_RANGE);
    HOLDS(reason.setting == 0 && strncmp(reason.text, "range_sigma_m must be", 21) == 0);

    /* Services have to be asked for, by the function of the filter's set. */
    IS(scphd_slam_audit(slam), SCPHD_STATUS_NO_SERVICES);
    IS(scphd_slam_digest(slam, &before), SCPHD_STATUS_NO_SERVICES);
    IS(scphd_services_joint_40(slam), SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_slam_audit(slam), SCPHD_STATUS_NO_SERVICES);
    IS(scphd_services_mixture_informed_4(NULL), SCPHD_STATUS_NULL_POINTER);
    OK(scphd_services_mixture_informed_4(slam));

    /* Before the first pose. */
    scphd_plane_pose pose;
    pose.struct_size = sizeof pose;
    IS(scphd_slam_predict(slam, 1.0f, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_NOT_RESET);
    IS(scphd_slam_scan_range_bearing(slam, 0, seen, 2, NULL), SCPHD_STATUS_NOT_RESET);
    IS(scphd_slam_estimate_pose(slam, &pose), SCPHD_STATUS_NOT_RESET);
    IS(scphd_slam_load_map(slam, NULL, 0), SCPHD_STATUS_NOT_RESET);
    IS(scphd_slam_relocate(slam, 0.0f, 0.0f, 0.0f, 0.1f, 0.1f), SCPHD_STATUS_NOT_RESET);
    OK(scphd_slam_reset(slam, about));
    IS(scphd_slam_relocate(slam, NAN, 0.0f, 0.0f, 0.1f, 0.1f), SCPHD_STATUS_BAD_POSE);
    OK(scphd_slam_scan_range_bearing(slam, 0, seen, 2, NULL));

    /* A description is no filter, and a filter no description. */
    IS(scphd_slam_scan_range_bearing((scphd_slam *)(void *)about, 0, seen, 2, NULL), SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_slam_reset(slam, (scphd_description *)(void *)slam), SCPHD_STATUS_WRONG_MEMORY);
    IS(scphd_description_set((scphd_description *)(void *)slam, SCPHD_JOINT_GATE, 0, 1.0f, NULL), SCPHD_STATUS_WRONG_MEMORY);

    OK(scphd_slam_digest(slam, &before));
    IS(scphd_slam_digest(slam, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_slam_scan_range_bearing(slam, 0, NULL, 2, NULL), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_slam_scan_range_bearing(slam, 0, (const scphd_range_bearing *)(const void *)((const char *)seen + 2), 1, NULL),
       SCPHD_STATUS_MISALIGNED);
    IS(scphd_slam_scan_range_bearing(slam, 0, seen, SIZE_MAX / 2, NULL), SCPHD_STATUS_ARRAY_TOO_LONG);
    IS(scphd_slam_scan_range_bearing(slam, 0, seen, 65, NULL), SCPHD_STATUS_TOO_MANY_MEASUREMENTS);
    IS(scphd_slam_scan_range_bearing(slam, 1, seen, 2, NULL), SCPHD_STATUS_NOT_DESCRIBED);
    IS(scphd_slam_scan_range_bearing(slam, 4, seen, 2, NULL), SCPHD_STATUS_NOT_DESCRIBED);
    IS(scphd_slam_scan_bearing(slam, 0, &seen[0].range_m, 2, NULL), SCPHD_STATUS_NOT_DESCRIBED);
    IS(scphd_slam_localise(slam, 0, seen, 2, NULL), SCPHD_STATUS_NOT_POSSIBLE);
    seen[1].bearing_rad = NAN;
    IS(scphd_slam_scan_range_bearing(slam, 0, seen, 2, NULL), SCPHD_STATUS_BAD_MEASUREMENT);
    scphd_scan_report report;
    report.struct_size = 3;
    IS(scphd_slam_scan_range_bearing(slam, 0, seen, 1, &report), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    pose.struct_size = 0;
    IS(scphd_slam_estimate_pose(slam, &pose), SCPHD_STATUS_WRONG_STRUCT_SIZE);
    IS(scphd_slam_observe_heading(slam, INFINITY, NULL), SCPHD_STATUS_BAD_MEASUREMENT);
    IS(scphd_slam_observe_position(slam, 0.0f, 0.0f, NULL), SCPHD_STATUS_NOT_DESCRIBED);
    scphd_odometry odometry = {.struct_size = sizeof odometry};
    IS(scphd_slam_estimate_odometry(slam, &odometry), SCPHD_STATUS_NOT_POSSIBLE);
    const scphd_feature nowhere = {.weight = 1.0f, .x_m = NAN};
    IS(scphd_slam_load_map(slam, &nowhere, 1), SCPHD_STATUS_BAD_MAP);
    IS(scphd_slam_load_map(slam, &nowhere, 129), SCPHD_STATUS_ARRAY_TOO_LONG);
    IS(scphd_slam_restore(slam, 0, (const uint8_t *)"no snapshot", 11), SCPHD_STATUS_BAD_SNAPSHOT);
    OK(scphd_slam_digest(slam, &after));
    HOLDS(before == after);
    OK(scphd_slam_audit(slam));

    /* What is refused of a prediction is told of by the next report. */
    IS(scphd_slam_predict(slam, NAN, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_BAD_CONTROL);
    IS(scphd_slam_predict(slam, 1.0f, 0.0f, 0.0f, -0.1f, NULL), SCPHD_STATUS_BAD_TIME_STEP);
    IS(scphd_slam_predict(slam, 400.0f, 0.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_IMPLAUSIBLE);
    IS(scphd_slam_predict(slam, 1.0f, 1.0f, 0.0f, 0.1f, NULL), SCPHD_STATUS_BAD_CONTROL);
    report.struct_size = sizeof report;
    OK(scphd_slam_scan_range_bearing(slam, 0, seen, 1, &report));
    HOLDS(report.refused == 4 && (report.health & SCPHD_HEALTH_PREDICTION_REFUSED) != 0);
    OK(scphd_slam_scan_range_bearing(slam, 0, NULL, 0, &report));
}

static void resuming(void) {
    scphd_slam *slam = (scphd_slam *)(void *)memory, *again = NULL;
    uint64_t before = 0, after = 1;
    const scphd_range_bearing seen = {5.0f, 0.1f};
    OK(scphd_slam_reset(slam, about));
    for (int step = 0; step < 20; step++) {
        OK(scphd_slam_predict(slam, 0.0f, 0.0f, 0.0f, 0.1f, NULL));
        OK(scphd_slam_scan_range_bearing(slam, 0, &seen, 1, NULL));
    }
    OK(scphd_slam_digest(slam, &before));

    /* A copy elsewhere is no filter until it is resumed. */
    memcpy(copy, memory, sizeof copy);
    IS(scphd_slam_digest((scphd_slam *)(void *)copy, &after), SCPHD_STATUS_NOT_STARTED);
    IS(scphd_resume_mixture_32x2(SCPHD_ABI_VERSION, copy, sizeof copy, about, NULL, &again), SCPHD_STATUS_MEMORY_TOO_SMALL);
    IS(scphd_resume_joint_40(SCPHD_ABI_VERSION, copy, sizeof copy, about, NULL, &again), SCPHD_STATUS_WRONG_MEMORY);
    OK(set(SCPHD_MIXTURE_PARTICLES, 3));
    IS(scphd_resume_mixture_informed_4(SCPHD_ABI_VERSION, copy, sizeof copy, about, NULL, &again),
       SCPHD_STATUS_OTHER_CONFIGURATION);
    OK(set(SCPHD_MIXTURE_PARTICLES, 4));
    IS(start(copy, sizeof copy, about, &again), SCPHD_STATUS_ALREADY_STARTED);
    OK(scphd_resume_mixture_informed_4(SCPHD_ABI_VERSION, copy, sizeof copy, about, NULL, &again));
    IS(scphd_slam_digest(again, &after), SCPHD_STATUS_NO_SERVICES);
    OK(scphd_services_mixture_informed_4(again));
    OK(scphd_slam_digest(again, &after));
    HOLDS(before == after);

    /* Both go on alike. */
    OK(scphd_slam_predict(slam, 1.0f, 0.0f, 0.1f, 0.1f, NULL));
    OK(scphd_slam_predict(again, 1.0f, 0.0f, 0.1f, 0.1f, NULL));
    OK(scphd_slam_scan_range_bearing(slam, 0, &seen, 1, NULL));
    OK(scphd_slam_scan_range_bearing(again, 0, &seen, 1, NULL));
    OK(scphd_slam_digest(slam, &before));
    OK(scphd_slam_digest(again, &after));
    HOLDS(before == after);

    /* A map in an array that is too small. */
    scphd_map map;
    map.struct_size = sizeof map;
    scphd_feature features[4];
    OK(scphd_slam_estimate_map(slam, features, 4, &map));
    HOLDS(map.features == 1 && map.left_out == 0 && fabsf(features[0].x_m - 5.0f) < 0.2f && features[0].weight > 0.5f);
    OK(scphd_slam_estimate_map(slam, NULL, 0, &map));
    HOLDS(map.features == 0 && map.left_out == 1);
    IS(scphd_slam_estimate_map(slam, NULL, 4, &map), SCPHD_STATUS_NULL_POINTER);
    IS(scphd_slam_estimate_map(slam, features, 4, NULL), SCPHD_STATUS_NULL_POINTER);
    scphd_mover mover;
    OK(scphd_slam_estimate_movers(slam, &mover, 1, &map));
    HOLDS(map.features == 0 && map.left_out == 0);

    /* Nothing to resume. */
    OK(scphd_release(copy, sizeof copy));
    IS(scphd_resume_mixture_informed_4(SCPHD_ABI_VERSION, copy, sizeof copy, about, NULL, &again), SCPHD_STATUS_NOT_STARTED);

    OK(set(SCPHD_FILTER, SCPHD_FILTER_JOINT));
    IS(scphd_resume_joint_40(SCPHD_ABI_VERSION, joint_memory, sizeof joint_memory, about, NULL, &again),
       SCPHD_STATUS_NOT_STARTED);
    OK(scphd_start_joint_40(SCPHD_ABI_VERSION, joint_memory, sizeof joint_memory, about, NULL, &again));
    OK(scphd_slam_reset(again, about));
    for (int step = 0; step < 20; step++) {
        OK(scphd_slam_scan_range_bearing(again, 0, &seen, 1, NULL));
    }
    OK(scphd_slam_estimate_map(again, features, 4, &map));
    HOLDS(map.features == 1 && fabsf(features[0].x_m - 5.0f) < 0.2f);
    OK(scphd_resume_joint_40(SCPHD_ABI_VERSION, joint_memory, sizeof joint_memory, about, NULL, &again));
    OK(scphd_slam_estimate_map(again, NULL, 0, &map));
    HOLDS(map.left_out == 1);

    /* A vehicle that moves sideways too. */
    OK(set(SCPHD_VEHICLE_KIND, SCPHD_VEHICLE_KIND_HOLONOMIC));
    OK(scphd_services_joint_40(again));
    OK(scphd_slam_configure(again, about, NULL));
    OK(scphd_slam_reset(again, about));
    OK(scphd_slam_predict(again, 1.0f, 2.0f, 0.0f, 0.5f, NULL));
    scphd_plane_pose sideways;
    sideways.struct_size = sizeof sideways;
    OK(scphd_slam_estimate_pose(again, &sideways));
    HOLDS(fabsf(sideways.x_m - 0.5f) < 1e-5f && fabsf(sideways.y_m - 1.0f) < 1e-5f);
    OK(set(SCPHD_VEHICLE_KIND, SCPHD_VEHICLE_KIND_UNICYCLE));
    OK(set(SCPHD_FILTER, SCPHD_FILTER_MIXTURE));
}

/* A filter in memory that ends where its set does: what writes beyond is seen by valgrind. */
static void to_the_last_byte(void) {
    scphd_slam *slam = NULL;
    void *exact = calloc(1, SCPHD_SIZE_MIXTURE_INFORMED_4);
    HOLDS(exact != NULL);
    OK(start(exact, SCPHD_SIZE_MIXTURE_INFORMED_4, about, &slam));
    OK(scphd_slam_reset(slam, about));
    OK(scphd_slam_predict(slam, 1.0f, 0.0f, 0.0f, 0.1f, NULL));
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
    reason.struct_size = sizeof reason;
    describing();
    starting();
    handles();
    resuming();
    to_the_last_byte();
    texts();
    printf("%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
