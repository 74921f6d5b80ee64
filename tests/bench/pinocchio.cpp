// Two contenders that use Pinocchio, in double and in float. Pinocchio computes the joints' placements and Jacobians,
// and from them those of the end effector.
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/multibody.hpp>

#include "peer.hpp"

namespace {

pinocchio::SE3 placement(const Pose &pose) {
    return {pose.rotation.toRotationMatrix(), pose.translation_m};
}

pinocchio::Model model_of(const Model &model) {
    pinocchio::Model result;
    pinocchio::JointIndex joint = 0;
    for (int i = 0; i < model.n; i++) {
        joint = result.addJoint(joint, pinocchio::JointModelRZ(), placement(model.fixed[i]),
                                "joint" + std::to_string(i));
        result.addJointFrame(joint);
    }
    result.addFrame(pinocchio::Frame("hand", joint, result.getFrameId("joint" + std::to_string(model.n - 1)),
                                     placement(model.effector), pinocchio::OP_FRAME));
    return result;
}

template <class Scalar, int N> struct Kinematics {
    explicit Kinematics(const Model &model)
        : model_(model_of(model).cast<Scalar>()), data_(model_), hand_(model_.getFrameId("hand")) {
        jacobian_.setZero();
    }

    void update(const Scalar q[]) {
        q_ = Eigen::Map<const Eigen::Matrix<Scalar, N, 1>>(q);
        pinocchio::computeJointJacobians(model_, data_, q_);
        pinocchio::updateFramePlacement(model_, data_, hand_);
        pinocchio::getFrameJacobian(model_, data_, hand_, pinocchio::LOCAL_WORLD_ALIGNED, jacobian_);
    }

    Eigen::Quaternion<Scalar> rotation() const { return Eigen::Quaternion<Scalar>(data_.oMf[hand_].rotation()); }
    Eigen::Matrix<Scalar, 3, 1> translation_m() const { return data_.oMf[hand_].translation(); }
    const Eigen::Matrix<Scalar, 6, N> &jacobian() const { return jacobian_; }

    pinocchio::ModelTpl<Scalar> model_;
    pinocchio::DataTpl<Scalar> data_;
    pinocchio::FrameIndex hand_;
    Eigen::Matrix<Scalar, N, 1> q_;
    Eigen::Matrix<Scalar, 6, N> jacobian_;
};

template <int N> struct Double {
    static std::unique_ptr<Contender> make(const Model &model) {
        return std::make_unique<Peer<double, N, Kinematics<double, N>>>("Pinocchio, double", model);
    }
};

template <int N> struct Float {
    static std::unique_ptr<Contender> make(const Model &model) {
        return std::make_unique<Peer<float, N, Kinematics<float, N>>>("Pinocchio, float", model);
    }
};

} // namespace

std::vector<std::unique_ptr<Contender>> pinocchio_contenders(const Model &model) {
    std::vector<std::unique_ptr<Contender>> result;
    result.push_back(with_joints<Double>(model.n, model));
    result.push_back(with_joints<Float>(model.n, model));
    return result;
}
