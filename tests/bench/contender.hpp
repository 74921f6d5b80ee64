// What is compared: one tick is Algorithm 1's loop body, forward kinematics, the Jacobian and law (4). Each contender has all of it
// in its own types; the joints' velocity is integrated into the angles of its next tick, so that latency counts.
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

// As bench.py writes it.
struct Model {
    std::string arm;            // the specialised arm's name
    int n;                      // joints, each about z of the frame that its `fixed` reaches
    std::vector<Pose> fixed;
    Pose effector;
    // Algorithm 1: the target's rotation is left r right, its translation virtual_start + R(left) (t - hand_start) - R(target) relation.
    Eigen::Quaterniond left, right;
    Eigen::Vector3d hand_start_m, virtual_start_m, relation_m;
    // Law (4) in the target's frame: rotation, translation.
    double weight[2], gain_per_s[2], damping;
    std::vector<double> start_rad;
    std::vector<Pose> hand;     // the person's, tick by tick; closed, so that it can be repeated
    std::vector<std::vector<double>> states; // angles for the check, with the hands in order
};

constexpr double TICK_S = 1e-3;

class Contender {
  public:
    virtual ~Contender() = default;
    virtual std::string name() const = 0;
    virtual void set(const double position_rad[]) = 0;
    virtual void ticks(int count) = 0;                                // from the first hand on
    virtual void velocity(int hand, double velocity_radps[]) = 0;     // of one tick, from the angles that are set
};

std::vector<std::unique_ptr<Contender>> ours(const Model &model);
std::vector<std::unique_ptr<Contender>> pinocchio_contenders(const Model &model);
std::vector<std::unique_ptr<Contender>> kdl_contenders(const Model &model);
std::vector<std::unique_ptr<Contender>> mujoco_contenders(const Model &model);
