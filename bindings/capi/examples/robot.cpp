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
    explicit Slam(float seed) {
        check(scphd_description_start(SCPHD_ABI_VERSION, robot_, sizeof robot_, &description_));
        set(SCPHD_FILTER, SCPHD_FILTER_MIXTURE);
        set(SCPHD_START_SEED, seed);
        set(SCPHD_NOISE_SPEED_SIGMA_MPS, 0.1f);
        set(SCPHD_NOISE_TURN_SIGMA, 0.02f);
        set(SCPHD_SENSOR_MODEL, SCPHD_SENSOR_MODEL_RANGE_BEARING);
        set(SCPHD_SENSOR_RANGE_MAX_M, 10.0f);
        set(SCPHD_SENSOR_RANGE_SIGMA_M, 0.1f);
        set(SCPHD_SENSOR_BEARING_SIGMA_RAD, 0.02f);
        scphd_reason reason{};
        reason.struct_size = sizeof reason;
        const scphd_status status =
            scphd_start_mixture_informed_4(SCPHD_ABI_VERSION, memory_, sizeof memory_, description_, &reason, &slam_);
        if (status == SCPHD_STATUS_OUT_OF_RANGE) {
            throw std::invalid_argument(scphd_setting_name(reason.setting));
        }
        check(status);
        check(scphd_services_mixture_informed_4(slam_)); // For the digest.
        check(scphd_slam_reset(slam_, description_));
    }
    Slam(const Slam &) = delete;
    Slam &operator=(const Slam &) = delete;

    void step(float speed_mps, const scphd_range_bearing *scan, std::size_t count) {
        check(scphd_slam_predict(slam_, speed_mps, 0.0f, 0.0f, 0.1f, nullptr));
        check(scphd_slam_scan_range_bearing(slam_, 0, scan, count, nullptr));
    }

    scphd_plane_pose pose() const {
        scphd_plane_pose pose{};
        pose.struct_size = sizeof pose;
        check(scphd_slam_estimate_pose(slam_, &pose));
        return pose;
    }

    std::uint64_t digest() const {
        std::uint64_t digest = 0;
        check(scphd_slam_digest(slam_, &digest));
        return digest;
    }

  private:
    void set(std::uint32_t setting, float number) { check(scphd_description_set(description_, setting, 0, number, nullptr)); }

    SCPHD_MEMORY(memory_, SCPHD_SIZE_MIXTURE_INFORMED_4){};
    SCPHD_MEMORY(robot_, SCPHD_SIZE_DESCRIPTION){};
    scphd_slam *slam_ = nullptr;
    scphd_description *description_ = nullptr;
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
