// Two contenders that use Orocos KDL: one applies control law (4) to KDL's forward kinematics and Jacobian and solves
// it by LDL^T, the other uses KDL's own damped least squares.
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "peer.hpp"

namespace {

KDL::Frame frame(const Pose &pose) {
    const Eigen::Quaterniond &r = pose.rotation;
    const Eigen::Vector3d &t = pose.translation_m;
    return {KDL::Rotation::Quaternion(r.x(), r.y(), r.z(), r.w()), KDL::Vector(t.x(), t.y(), t.z())};
}

KDL::Chain chain_of(const Model &model, int joints) {
    KDL::Chain chain;
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), frame(model.fixed[0])));
    for (int i = 0; i < model.n; i++) {
        chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ),
                                      frame(i + 1 < model.n ? model.fixed[i + 1] : model.effector)));
    }
    for (int i = model.n; i < joints; i++) {
        chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ)));
    }
    return chain;
}

template <int N> struct Kinematics {
    explicit Kinematics(const Model &model)
        : chain_(chain_of(model, N)), fk_(chain_), jac_(chain_), q_(N), jacobian_(N) {}

    void update(const double q[]) {
        q_.data = Eigen::Map<const Eigen::Matrix<double, N, 1>>(q);
        fk_.JntToCart(q_, hand_);
        jac_.JntToJac(q_, jacobian_);
    }

    Eigen::Quaterniond rotation() const {
        Eigen::Quaterniond r;
        hand_.M.GetQuaternion(r.x(), r.y(), r.z(), r.w());
        return r;
    }
    Eigen::Vector3d translation_m() const { return {hand_.p.x(), hand_.p.y(), hand_.p.z()}; }
    Eigen::Map<const Eigen::Matrix<double, 6, N>> jacobian() const {
        return Eigen::Map<const Eigen::Matrix<double, 6, N>>(jacobian_.data.data());
    }

    KDL::Chain chain_;
    KDL::ChainFkSolverPos_recursive fk_;
    KDL::ChainJntToJacSolver jac_;
    KDL::JntArray q_;
    KDL::Frame hand_;
    KDL::Jacobian jacobian_;
};

template <int N> struct SameLaw {
    static std::unique_ptr<Contender> make(const Model &model) {
        return std::make_unique<Peer<double, N, Kinematics<N>>>("KDL, law (4)", model);
    }
};

// Passes the twist that closes the error, scaled by gain and weights, to ChainIkSolverVel_wdls, as a KDL user would do.
// The solver accesses a 6 x 6 block of its 6 x n matrix and therefore aborts if n is below 6, so locked joints are
// appended to the end effector of shorter arms.
class DampedLeastSquares : public Contender {
  public:
    explicit DampedLeastSquares(const Model &model)
        : model_(model), joints_(std::max(model.n, 6)), chain_(chain_of(model, joints_)), fk_(chain_), solver_(chain_),
          q_(joints_), u_(joints_) {
        solver_.setLambda(std::sqrt(model.damping));
        Eigen::MatrixXd unlocked = Eigen::MatrixXd::Zero(joints_, joints_);
        unlocked.topLeftCorner(model.n, model.n).setIdentity();
        solver_.setWeightJS(unlocked);
        Eigen::MatrixXd weight = Eigen::MatrixXd::Identity(6, 6);
        weight.topLeftCorner(3, 3) *= std::sqrt(model.weight[1]) / 2;
        weight.bottomRightCorner(3, 3) *= std::sqrt(model.weight[0]) / 2;
        solver_.setWeightTS(weight);
        left_ = frame({model.left, Eigen::Vector3d::Zero()}).M;
        right_ = frame({model.right, Eigen::Vector3d::Zero()}).M;
        for (const Pose &hand : model.hand) {
            hand_.push_back(frame(hand));
        }
        hand_start_ = frame({model.left, model.hand_start_m}).p;
        virtual_start_ = frame({model.left, model.virtual_start_m}).p;
        relation_ = frame({model.left, model.relation_m}).p;
    }

    std::string name() const override { return "KDL, wdls"; }

    void set(const double position_rad[]) override {
        for (int i = 0; i < model_.n; i++) {
            q_(i) = position_rad[i];
        }
    }

    void ticks(int count) override {
        const int hands = int(hand_.size());
        for (int k = 0, h = 0; k < count; k++, h = h + 1 == hands ? 0 : h + 1) {
            tick(h);
            for (int i = 0; i < model_.n; i++) {
                q_(i) += TICK_S * u_(i);
            }
        }
    }

    void velocity(int hand, double velocity_radps[]) override {
        tick(hand);
        for (int i = 0; i < model_.n; i++) {
            velocity_radps[i] = u_(i);
        }
    }

  private:
    void tick(int h) {
        KDL::Frame target;
        target.M = left_ * hand_[h].M * right_;
        target.p = virtual_start_ + left_ * (hand_[h].p - hand_start_) - target.M * relation_;
        KDL::Frame now;
        fk_.JntToCart(q_, now);
        KDL::Twist twist = KDL::diff(now, target);
        twist.vel = model_.gain_per_s[1] * twist.vel;
        twist.rot = model_.gain_per_s[0] * twist.rot;
        solver_.CartToJnt(q_, twist, u_);
    }

    const Model &model_;
    int joints_;
    KDL::Chain chain_;
    KDL::ChainFkSolverPos_recursive fk_;
    KDL::ChainIkSolverVel_wdls solver_;
    KDL::JntArray q_, u_;
    KDL::Rotation left_, right_;
    KDL::Vector hand_start_, virtual_start_, relation_;
    std::vector<KDL::Frame> hand_;
};

} // namespace

std::vector<std::unique_ptr<Contender>> kdl_contenders(const Model &model) {
    std::vector<std::unique_ptr<Contender>> result;
    result.push_back(with_joints<SameLaw>(model.n, model));
    result.push_back(std::make_unique<DampedLeastSquares>(model));
    return result;
}
