/* All that filters can do beside driving: maps, snapshots, movers, an archive, odometry that is learnt, watches. */
#include "check.h"
#include <math.h>

static SCPHD_MEMORY(about_memory, SCPHD_SIZE_DESCRIPTION);
static SCPHD_MEMORY(slam_memory, SCPHD_SIZE_JOINT_100);
static SCPHD_MEMORY(other_memory, SCPHD_SIZE_JOINT_100);
static SCPHD_MEMORY(movers_memory, SCPHD_SIZE_JOINT_60_MOVERS);
static SCPHD_MEMORY(learning_memory, SCPHD_SIZE_JOINT_60_LEARNING);
static SCPHD_MEMORY(archive_memory, SCPHD_SIZE_JOINT_40_ARCHIVE);
static SCPHD_MEMORY(mixture_memory, SCPHD_SIZE_MIXTURE_INFORMED_4);

static scphd_description *about;
static scphd_slam *slam;

static void set(uint32_t setting, float number) { OK(scphd_description_set(about, setting, 0, number, NULL)); }

/* Eight posts around the start, and somebody who walks past, as a robot that turns in place sees them. */
static size_t look(int step, scphd_range_bearing *scan) {
    const float heading = 0.02f * (float)step, walked = 0.1f * (float)step;
    for (int post = 0; post < 8; post++) {
        const float bearing = 0.7854f * (float)post - heading;
        scan[post].range_m = 4.0f + 0.5f * (float)post;
        scan[post].bearing_rad = atan2f(sinf(bearing), cosf(bearing));
    }
    const float bearing = atan2f(2.0f, walked - 3.0f) - heading;
    scan[8].range_m = hypotf(2.0f, walked - 3.0f);
    scan[8].bearing_rad = atan2f(sinf(bearing), cosf(bearing));
    return 9;
}

static void drive(scphd_status (*services)(scphd_slam *)) {
    OK(services(slam));
    scphd_range_bearing scan[9];
    OK(scphd_slam_reset(slam, about));
    for (int step = 1; step <= 60; step++) {
        OK(scphd_slam_predict(slam, 0.0f, 0.0f, 0.2f, 0.1f, NULL));
        OK(scphd_slam_scan_range_bearing(slam, 0, scan, look(step, scan), NULL));
    }
    OK(scphd_slam_audit(slam));
}

static uint64_t digest(scphd_slam *of) {
    uint64_t digest = 0;
    OK(scphd_slam_digest(of, &digest));
    return digest;
}

static void describe(void) {
    OK(scphd_description_start(SCPHD_ABI_VERSION, about_memory, sizeof about_memory, &about));
    set(SCPHD_SENSOR_MODEL, SCPHD_SENSOR_MODEL_RANGE_BEARING);
    set(SCPHD_SENSOR_RANGE_MAX_M, 12.0f);
    set(SCPHD_SENSOR_RANGE_SIGMA_M, 0.1f);
    set(SCPHD_SENSOR_BEARING_SIGMA_RAD, 0.03f);
    set(SCPHD_SENSOR_BIRTHS_STILL, 0.001f);
}

/* A map and a snapshot, taken from one filter and given to another. */
static void maps_and_snapshots(void) {
    OK(scphd_start_joint_100(SCPHD_ABI_VERSION, slam_memory, sizeof slam_memory, about, NULL, &slam));
    drive(scphd_services_joint_100);
    scphd_feature features[16];
    scphd_map map = {.struct_size = sizeof map};
    OK(scphd_slam_estimate_map(slam, features, 16, &map));
    HOLDS(map.features >= 8);
    scphd_slam *other = NULL;
    OK(scphd_start_joint_100(SCPHD_ABI_VERSION, other_memory, sizeof other_memory, about, NULL, &other));
    OK(scphd_slam_reset(other, about));
    IS(scphd_slam_load_map(other, features, map.features), SCPHD_STATUS_NO_SERVICES);
    IS(scphd_services_mixture_informed_4(other), SCPHD_STATUS_WRONG_MEMORY);
    OK(scphd_services_joint_100(other));
    OK(scphd_slam_load_map(other, features, map.features));
    OK(scphd_slam_relocate(other, 0.0f, 0.0f, 0.1f, 0.2f, 0.2f));
    OK(scphd_slam_scatter(other, 0.1f, 0.1f));
    scphd_range_bearing scan[9];
    scphd_scan_report report = {.struct_size = sizeof report};
    look(0, scan);
    OK(scphd_slam_localise(other, 0, scan, 8, &report));
    HOLDS(report.measurements == 8 && report.detections > 7.0f && report.births == 0);
    scphd_plane_pose pose = {.struct_size = sizeof pose};
    OK(scphd_slam_estimate_pose(other, &pose));
    HOLDS(fabsf(pose.heading_rad) < 0.05f);

    static uint8_t snapshot[65536];
    size_t size = 0, written = 0;
    OK(scphd_slam_save(slam, 7, NULL, 0, &size));
    HOLDS(size > 0 && size <= sizeof snapshot);
    IS(scphd_slam_save(slam, 7, snapshot, size - 1, &written), SCPHD_STATUS_BAD_SNAPSHOT);
    OK(scphd_slam_save(slam, 7, snapshot, sizeof snapshot, &written));
    HOLDS(written == size);
    OK(scphd_slam_restore(other, 7, snapshot, size));
    HOLDS(digest(other) == digest(slam));
    IS(scphd_slam_restore(other, 8, snapshot, size), SCPHD_STATUS_BAD_SNAPSHOT);
}

static void movers(void) {
    scphd_reason reason = {.struct_size = sizeof reason};
    IS(scphd_start_joint_60_movers(SCPHD_ABI_VERSION, movers_memory, sizeof movers_memory, about, &reason, &slam),
       SCPHD_STATUS_NOT_DESCRIBED);
    HOLDS(reason.setting == SCPHD_JOINT_MOVERS);
    set(SCPHD_JOINT_MOVERS, SCPHD_JOINT_MOVERS_YES);
    set(SCPHD_SENSOR_BIRTHS_MOVING, 0.001f);
    OK(scphd_start_joint_60_movers(SCPHD_ABI_VERSION, movers_memory, sizeof movers_memory, about, &reason, &slam));
    drive(scphd_services_joint_60_movers);
    scphd_map map = {.struct_size = sizeof map};
    scphd_mover walker[1];
    OK(scphd_slam_estimate_movers(slam, walker, 1, &map));
    HOLDS(map.features == 1 && fabsf(walker[0].vx_mps - 1.0f) < 0.3f && fabsf(walker[0].y_m - 2.0f) < 0.5f);

    /* With an archive beside. */
    set(SCPHD_JOINT_ARCHIVE, SCPHD_JOINT_ARCHIVE_YES);
    IS(scphd_slam_configure(slam, about, &reason), SCPHD_STATUS_NO_ROOM);
    OK(scphd_start_joint_40_archive(SCPHD_ABI_VERSION, archive_memory, sizeof archive_memory, about, NULL, &slam));
    drive(scphd_services_joint_40_archive);
    OK(scphd_slam_load_map(slam, NULL, 0));
    OK(scphd_slam_estimate_map(slam, NULL, 0, &map));
    HOLDS(map.features + map.left_out == 0);
    set(SCPHD_JOINT_ARCHIVE_REACH_M, 20.0f);
    IS(scphd_slam_configure(slam, about, &reason), SCPHD_STATUS_NOT_POSSIBLE);
    set(SCPHD_JOINT_ARCHIVE, SCPHD_JOINT_ARCHIVE_NO);
    set(SCPHD_JOINT_MOVERS, SCPHD_JOINT_MOVERS_NO);
    set(SCPHD_SENSOR_BIRTHS_MOVING, 0.0f);
}

static void learning(void) {
    set(SCPHD_JOINT_ODOMETRY, SCPHD_JOINT_ODOMETRY_YES);
    OK(scphd_start_joint_60_learning(SCPHD_ABI_VERSION, learning_memory, sizeof learning_memory, about, NULL, &slam));
    drive(scphd_services_joint_60_learning);
    scphd_odometry odometry = {.struct_size = sizeof odometry};
    OK(scphd_slam_estimate_odometry(slam, &odometry));
    HOLDS(fabsf(odometry.speed_scale) < 0.1f && fabsf(odometry.turn_scale) < 0.1f);
    set(SCPHD_JOINT_ODOMETRY, SCPHD_JOINT_ODOMETRY_NO);
}

/* A mixture of a vehicle that moves sideways, with a watch over its fixes. */
static void watch(void) {
    set(SCPHD_FILTER, SCPHD_FILTER_MIXTURE);
    set(SCPHD_VEHICLE_KIND, SCPHD_VEHICLE_KIND_HOLONOMIC);
    set(SCPHD_POSITION, SCPHD_POSITION_YES);
    set(SCPHD_POSITION_SIGMA, 0.5f);
    set(SCPHD_POSITION_GATE, 25.0f);
    set(SCPHD_POSITION_WATCH, SCPHD_POSITION_WATCH_YES);
    OK(scphd_start_mixture_informed_4(SCPHD_ABI_VERSION, mixture_memory, sizeof mixture_memory, about, NULL, &slam));
    OK(scphd_slam_reset(slam, about));
    IS(scphd_slam_observe_position(slam, 0.0f, 0.0f, NULL), SCPHD_STATUS_NO_SERVICES);
    OK(scphd_services_mixture_informed_4(slam));
    scphd_fix_report report = {.struct_size = sizeof report};
    for (int second = 1; second < 12 && report.relocated == 0; second++) {
        for (int step = 0; step < 10; step++) {
            OK(scphd_slam_predict(slam, 1.0f, 1.0f, 0.0f, 0.1f, NULL));
        }
        OK(scphd_slam_observe_position(slam, (float)second, 30.0f + (float)second, &report));
    }
    HOLDS(report.relocated == 1);
    IS(scphd_slam_observe_heading(slam, 0.0f, NULL), SCPHD_STATUS_NOT_DESCRIBED);
}

int main(void) {
    describe();
    maps_and_snapshots();
    movers();
    learning();
    watch();
    printf("%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
