// The part of the tick that the contenders with other libraries share: Algorithm 1, control law (4) and the loop,
// written with Eigen as a user of these libraries would write it.
#pragma once

#include "contender.hpp"

template <class Scalar> struct PoseOf {
    Eigen::Quaternion<Scalar> rotation;
    Eigen::Matrix<Scalar, 3, 1> translation_m;
};

// Kinematics is a struct with `void update(const Scalar q[])`, the end effector's `rotation()` and `translation_m()` in
// the torso frame, and `jacobian()`, which is 6 x n in torso axes with the linear velocity above the angular velocity.
template <class Scalar, int N, class Kinematics> class Peer : public Contender {
    using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
    using Quaternion = Eigen::Quaternion<Scalar>;

  public:
    Peer(std::string name, const Model &model) : name_(std::move(name)), kinematics_(model) {
        left_ = model.left.cast<Scalar>();
        right_ = model.right.cast<Scalar>();
        turn_ = left_.toRotationMatrix();
        hand_start_ = model.hand_start_m.cast<Scalar>();
        virtual_start_ = model.virtual_start_m.cast<Scalar>();
        relation_ = model.relation_m.cast<Scalar>();
        for (const Pose &hand : model.hand) {
            hand_.push_back({hand.rotation.cast<Scalar>(), hand.translation_m.cast<Scalar>()});
        }
        weight_rotation_ = Scalar(model.weight[0]);
        weight_translation_ = Scalar(model.weight[1]);
        pull_rotation_ = Scalar(2 * model.weight[0] * model.gain_per_s[0]);
        pull_translation_ = Scalar(model.weight[1] * model.gain_per_s[1]);
        damping_ = Scalar(4 * model.damping);
    }

    std::string name() const override { return name_; }

    void set(const double position_rad[]) override {
        for (int i = 0; i < N; i++) {
            q_[i] = Scalar(position_rad[i]);
        }
    }

    void ticks(int count) override {
        const int hands = int(hand_.size());
        for (int k = 0, h = 0; k < count; k++, h = h + 1 == hands ? 0 : h + 1) {
            tick(h);
            q_ += Scalar(TICK_S) * u_;
        }
    }

    void velocity(int hand, double velocity_radps[]) override {
        tick(hand);
        for (int i = 0; i < N; i++) {
            velocity_radps[i] = double(u_[i]);
        }
    }

  private:
    void tick(int h) {
        const Quaternion target = left_ * hand_[h].rotation * right_;
        const Vector3 place = virtual_start_ + turn_ * (hand_[h].translation_m - hand_start_) - target * relation_;
        kinematics_.update(q_.data());
        law(target, place);
    }

    // Control law (4) with the error in the target's frame. Both sides of its normal equations are multiplied by 4. W
    // and K have one value for rotation and one for translation. When expressed in the torso frame and multiplied on
    // the right by conj(conj(q_d) q) (an orthogonal map), a joint's column of the dual quaternion Jacobian is
    // (omega; v + t x omega / 2; t . omega / 2) / 2, where t is the vector from the target to the end effector.
    void law(const Quaternion &target, const Vector3 &place) {
        Quaternion turn = kinematics_.rotation() * target.conjugate();
        const Vector3 delta = turn.w() < 0 ? Vector3(-turn.vec()) : Vector3(turn.vec());
        const Vector3 t = kinematics_.translation_m() - place;
        const auto &jacobian = kinematics_.jacobian();
        Eigen::Matrix<Scalar, 3, N> linear;
        Eigen::Matrix<Scalar, 1, N> along;
        for (int i = 0; i < N; i++) {
            const Vector3 omega = jacobian.template block<3, 1>(3, i);
            linear.col(i) = jacobian.template block<3, 1>(0, i) + Scalar(0.5) * t.cross(omega);
            along[i] = Scalar(0.5) * t.dot(omega);
        }
        const auto angular = jacobian.template bottomRows<3>();
        Eigen::Matrix<Scalar, N, N> normal =
            weight_rotation_ * (angular.transpose() * angular) +
            weight_translation_ * (linear.transpose() * linear + along.transpose() * along);
        normal.diagonal().array() += damping_;
        const Eigen::Matrix<Scalar, N, 1> pull = -pull_rotation_ * (angular.transpose() * delta) -
                                                 pull_translation_ * (linear.transpose() * t);
        u_ = normal.ldlt().solve(pull);
    }

    std::string name_;
    Kinematics kinematics_;
    Quaternion left_, right_;
    Eigen::Matrix<Scalar, 3, 3> turn_;
    Vector3 hand_start_, virtual_start_, relation_;
    std::vector<PoseOf<Scalar>> hand_;
    Scalar weight_rotation_, weight_translation_, pull_rotation_, pull_translation_, damping_;
    Eigen::Matrix<Scalar, N, 1> q_, u_;
};

// Turns the number of joints into a compile-time constant for the peers.
template <template <int> class Make, class... Arguments>
std::unique_ptr<Contender> with_joints(int n, Arguments &&...arguments) {
    switch (n) {
    case 4:
        return Make<4>::make(arguments...);
    case 6:
        return Make<6>::make(arguments...);
    default:
        return Make<7>::make(arguments...);
    }
}
