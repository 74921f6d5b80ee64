// A contender that uses MuJoCo: its kinematics, its centres of mass, which its Jacobian needs, and the Jacobian of a
// site at the end effector.
#include <mujoco/mujoco.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "peer.hpp"

namespace {

std::string numbers(const Pose &pose) {
    char text[300];
    const Eigen::Quaterniond &r = pose.rotation;
    const Eigen::Vector3d &t = pose.translation_m;
    std::snprintf(text, sizeof text, "pos=\"%.17g %.17g %.17g\" quat=\"%.17g %.17g %.17g %.17g\"", t.x(), t.y(), t.z(),
                  r.w(), r.x(),
                  r.y(), r.z());
    return text;
}

std::string mjcf(const Model &model) {
    std::string text = "<mujoco><compiler angle=\"radian\"/><worldbody>", end;
    for (int i = 0; i < model.n; i++) {
        text += "<body " + numbers(model.fixed[i]) +
                "><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><joint axis=\"0 0 1\"/>";
        end += "</body>";
    }
    return text + "<site name=\"hand\" " + numbers(model.effector) + "/>" + end + "</worldbody></mujoco>";
}

mjModel *load(const Model &model) {
    const std::string text = mjcf(model);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_addBufferVFS(&files, "arm.xml", text.data(), int(text.size()));
    char error[500] = "";
    mjModel *result = mj_loadXML("arm.xml", &files, error, sizeof error);
    if (result == nullptr) {
        std::fprintf(stderr, "MuJoCo: %s\n", error);
        std::exit(EXIT_FAILURE);
    }
    mj_deleteVFS(&files);
    return result;
}

template <int N> struct Kinematics {
    explicit Kinematics(const Model &model) : model_(load(model)), data_(mj_makeData(model_)) {
        hand_ = mj_name2id(model_, mjOBJ_SITE, "hand");
    }

    void update(const double q[]) {
        std::memcpy(data_->qpos, q, N * sizeof *q);
        mj_kinematics(model_, data_);
        mj_comPos(model_, data_);
        mj_jacSite(model_, data_, rows_, rows_ + 3 * N, hand_);
        jacobian_ = Eigen::Map<const Eigen::Matrix<double, 6, N, Eigen::RowMajor>>(rows_);
    }

    Eigen::Quaterniond rotation() const {
        return Eigen::Quaterniond(Eigen::Matrix3d(
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->site_xmat + 9 * hand_)));
    }
    Eigen::Vector3d translation_m() const { return Eigen::Map<const Eigen::Vector3d>(data_->site_xpos + 3 * hand_); }
    const Eigen::Matrix<double, 6, N> &jacobian() const { return jacobian_; }

    mjModel *model_;
    mjData *data_;
    int hand_;
    double rows_[6 * N];
    Eigen::Matrix<double, 6, N> jacobian_;
};

template <int N> struct Make {
    static std::unique_ptr<Contender> make(const Model &model) {
        return std::make_unique<Peer<double, N, Kinematics<N>>>("MuJoCo", model);
    }
};

} // namespace

std::vector<std::unique_ptr<Contender>> mujoco_contenders(const Model &model) {
    std::vector<std::unique_ptr<Contender>> result;
    result.push_back(with_joints<Make>(model.n, model));
    return result;
}
