// comanip's own tick in two versions: the code generated for one arm, and the general code with the arm's table.
#include "contender.hpp"
#include "tick.h"

namespace {

std::vector<double> flat(const std::vector<Pose> &poses) {
    std::vector<double> result;
    for (const Pose &pose : poses) {
        const Eigen::Quaterniond &r = pose.rotation;
        const Eigen::Vector3d &t = pose.translation_m;
        result.insert(result.end(), {r.w(), r.x(), r.y(), r.z(), t.x(), t.y(), t.z()});
    }
    return result;
}

class Comanip : public Contender {
  public:
    Comanip(std::string name, const char *arm, const Model &model) : name_(std::move(name)) {
        std::vector<Pose> chain = model.fixed;
        chain.push_back(model.effector);
        const std::vector<double> fixed = flat(chain), hands = flat(model.hand);
        const tick_model_t description = {arm,
                                          model.n,
                                          int(model.hand.size()),
                                          fixed.data(),
                                          hands.data(),
                                          model.start_rad.data(),
                                          {model.weight[0], model.weight[1]},
                                          {model.gain_per_s[0], model.gain_per_s[1]},
                                          model.damping};
        tick_ = tick_create(&description);
    }

    std::string name() const override { return name_; }
    void set(const double position_rad[]) override { tick_set(tick_, position_rad); }
    void ticks(int count) override { tick_run(tick_, count); }
    void velocity(int hand, double velocity_radps[]) override { tick_once(tick_, hand, velocity_radps); }

  private:
    std::string name_;
    tick_t *tick_;
};

} // namespace

std::vector<std::unique_ptr<Contender>> ours(const Model &model) {
    std::vector<std::unique_ptr<Contender>> result;
    result.push_back(std::make_unique<Comanip>("comanip, specialised", model.arm.c_str(), model));
    result.push_back(std::make_unique<Comanip>("comanip, table", nullptr, model));
    return result;
}
