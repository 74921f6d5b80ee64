// The tick that is compared consists of Algorithm 1's loop body, forward kinematics, the Jacobian and control law (4).
// Each contender uses its own types. It integrates its joint velocities and starts the next tick from the resulting
// angles. The processor therefore cannot overlap ticks, and the benchmark measures the latency of a tick.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/Geometry>

struct Pose {
    Eigen::Quaterniond rotation;
    Eigen::Vector3d translation_m;
};

// The model that bench.py writes.
struct Model {
    std::string arm;            // name of the specialised arm
    int n;                      // number of joints; each turns about z of the frame given by its `fixed`
    std::vector<Pose> fixed;
    Pose effector;
    // Algorithm 1, with the hand's rotation r and translation t: the target's rotation is left r right, and its
    // translation is virtual_start + R(left) (t - hand_start) - R(target) relation.
    Eigen::Quaterniond left, right;
    Eigen::Vector3d hand_start_m, virtual_start_m, relation_m;
    // Control law (4) with the error in the target's frame. Arrays: the values for rotation and for translation.
    double weight[2], gain_per_s[2], damping;
    std::vector<double> start_rad;
    std::vector<Pose> hand;     // the person's hand in successive ticks, a closed path that is repeated
    std::vector<std::vector<double>> states; // joint angles for the check; state i is used with hand pose i
};

constexpr double TICK_S = 1e-3;

class Contender {
  public:
    virtual ~Contender() = default;
    virtual std::string name() const = 0;
    virtual void set(const double position_rad[]) = 0;
    virtual void ticks(int count) = 0;                                // starts with the first hand pose
    virtual void velocity(int hand, double velocity_radps[]) = 0;     // result of one tick at the angles given to set()
};

std::vector<std::unique_ptr<Contender>> ours(const Model &model);
std::vector<std::unique_ptr<Contender>> pinocchio_contenders(const Model &model);
std::vector<std::unique_ptr<Contender>> kdl_contenders(const Model &model);
std::vector<std::unique_ptr<Contender>> mujoco_contenders(const Model &model);
