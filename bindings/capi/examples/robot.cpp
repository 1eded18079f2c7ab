// Two filters at once in C++17, each owned by an object: the header is the same as for C.
#include <cstdio>
#include <memory>
#include <scphd.h>
#include <stdexcept>

namespace {

void check(scphd_status status) {
    if (status != SCPHD_STATUS_OK) {
        throw std::runtime_error(scphd_error_text(status));
    }
}

// Not moved nor copied: the filter lives in the object.
class Slam {
  public:
    explicit Slam(std::uint64_t seed) {
        scphd_plane_config config{};
        config.struct_size = sizeof config;
        check(scphd_plane_informed(&config, 4));
        config.vehicle.speed_sigma_mps = 0.1f;
        config.vehicle.turn_sigma = 0.02f;
        scphd_reason reason{};
        reason.struct_size = sizeof reason;
        const scphd_status status = scphd_plane_start(SCPHD_ABI_VERSION, SCPHD_SET_PLANE_INFORMED_4, memory_, sizeof memory_,
                                                      &config, &reason, &filter_);
        if (status == SCPHD_STATUS_OUT_OF_RANGE) {
            throw std::invalid_argument(reason.text);
        }
        check(status);
        check(scphd_plane_reset(filter_, 0.0f, 0.0f, 0.0f, seed));

        scphd_range_bearing_config lidar{};
        lidar.struct_size = sizeof lidar;
        check(scphd_range_bearing_defaults(&lidar, 10.0f, 0.9f));
        lidar.range_sigma_m = 0.1f;
        lidar.bearing_sigma_rad = 0.02f;
        check(scphd_range_bearing_start(SCPHD_ABI_VERSION, SCPHD_SET_RANGE_BEARING_32, lidar_memory_, sizeof lidar_memory_, &lidar,
                                        nullptr, &lidar_));
    }
    Slam(const Slam &) = delete;
    Slam &operator=(const Slam &) = delete;

    void step(float speed_mps, const scphd_range_bearing *scan, std::size_t count) {
        check(scphd_plane_predict_robot(filter_, speed_mps, 0.0f, 0.1f, nullptr));
        check(scphd_plane_scan_range_bearing(filter_, lidar_, scan, count, nullptr));
    }

    scphd_plane_pose pose() const {
        scphd_plane_pose pose{};
        pose.struct_size = sizeof pose;
        check(scphd_plane_estimate_pose(filter_, &pose));
        return pose;
    }

    std::uint64_t digest() const {
        std::uint64_t digest = 0;
        check(scphd_plane_digest(filter_, &digest));
        return digest;
    }

  private:
    SCPHD_MEMORY(memory_, SCPHD_SIZE_PLANE_INFORMED_4){};
    SCPHD_MEMORY(lidar_memory_, SCPHD_SIZE_RANGE_BEARING_32){};
    scphd_plane *filter_ = nullptr;
    scphd_range_bearing_detector *lidar_ = nullptr;
};

} // namespace

int main() try {
    const auto one = std::make_unique<Slam>(1), other = std::make_unique<Slam>(1);
    for (int step = 1; step <= 50; step++) {
        // A post 10 m ahead, which comes nearer by 0.1 m a step.
        const scphd_range_bearing scan[] = {{9.5f - 0.1f * static_cast<float>(step), 0.0f}};
        one->step(1.0f, scan, 1);
        other->step(1.0f, scan, 1);
    }
    const scphd_plane_pose pose = one->pose();
    std::printf("%.2f m ahead\n", static_cast<double>(pose.x_m));
    return pose.x_m > 4.5f && pose.x_m < 5.5f && one->digest() == other->digest() ? 0 : 1;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
