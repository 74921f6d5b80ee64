// ticks MODEL check            prints each contender's velocities in each of the model's states, one state per line
// ticks MODEL time TICKS       prints ns and heap allocations per tick of each contender
// ticks MODEL run TICKS NAME   runs only the contender NAME, for callgrind
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "contender.hpp"

// Counts all heap allocations of this process.
static long allocations;

extern "C" {
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);

void *malloc(size_t size) {
    allocations++;
    return __libc_malloc(size);
}
void *calloc(size_t count, size_t size) {
    allocations++;
    return __libc_calloc(count, size);
}
void *realloc(void *block, size_t size) {
    allocations++;
    return __libc_realloc(block, size);
}
void *aligned_alloc(size_t alignment, size_t size) {
    allocations++;
    return __libc_memalign(alignment, size);
}
int posix_memalign(void **block, size_t alignment, size_t size) {
    allocations++;
    *block = __libc_memalign(alignment, size);
    return 0;
}
}

namespace {

Pose read_pose(std::istream &in) {
    double w, x, y, z, a, b, c;
    in >> w >> x >> y >> z >> a >> b >> c;
    return {Eigen::Quaterniond(w, x, y, z), Eigen::Vector3d(a, b, c)};
}

std::vector<double> read_numbers(std::istream &in, int count) {
    std::vector<double> result(count);
    for (double &value : result) {
        in >> value;
    }
    return result;
}

Model read_model(const char *path) {
    std::ifstream in(path);
    Model model;
    int hands, states;
    in >> model.arm >> model.n >> hands >> states;
    for (int i = 0; i < model.n; i++) {
        model.fixed.push_back(read_pose(in));
    }
    model.effector = read_pose(in);
    const Pose left = read_pose(in), right = read_pose(in); // their translations are hand_start_m and virtual_start_m
    model.left = left.rotation, model.hand_start_m = left.translation_m;
    model.right = right.rotation, model.virtual_start_m = right.translation_m;
    in >> model.relation_m.x() >> model.relation_m.y() >> model.relation_m.z();
    in >> model.weight[0] >> model.weight[1] >> model.gain_per_s[0] >> model.gain_per_s[1] >> model.damping;
    model.start_rad = read_numbers(in, model.n);
    for (int i = 0; i < hands; i++) {
        model.hand.push_back(read_pose(in));
    }
    for (int i = 0; i < states; i++) {
        model.states.push_back(read_numbers(in, model.n));
    }
    if (!in) {
        std::fprintf(stderr, "%s: cannot be read as a model; expected a file written by bench.py\n", path);
        std::exit(EXIT_FAILURE);
    }
    return model;
}

void check(Contender &contender, const Model &model) {
    std::vector<double> velocity(model.n);
    for (size_t i = 0; i < model.states.size(); i++) {
        contender.set(model.states[i].data());
        contender.velocity(int(i), velocity.data());
        std::printf("%s", contender.name().c_str());
        for (double value : velocity) {
            std::printf("\t%.17g", value);
        }
        std::printf("\n");
    }
}

double now_ns() {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) * 1e9 + double(t.tv_nsec);
}

void time(Contender &contender, const Model &model, int count) {
    contender.set(model.start_rad.data());
    contender.ticks(count / 10); // warms the caches
    const long before = allocations;
    const double start_ns = now_ns();
    contender.ticks(count);
    const double ns = now_ns() - start_ns;
    const long heap = allocations - before;
    std::printf("%s\t%.17g\t%.17g\n", contender.name().c_str(), ns / count, double(heap) / count);
}

} // namespace

int main(int argc, char **argv) {
    const std::string mode = argc > 2 ? argv[2] : "";
    const int count = argc > 3 ? std::atoi(argv[3]) : 0;
    if (!((mode == "check" && argc == 3) || (mode == "time" && argc == 4 && count > 0) ||
          (mode == "run" && argc == 5 && count > 0))) {
        std::fprintf(stderr, "usage: ticks MODEL check | ticks MODEL time TICKS | ticks MODEL run TICKS NAME\n");
        return 2;
    }
    const Model model = read_model(argv[1]);
    std::vector<std::unique_ptr<Contender>> all;
    for (auto make : {ours, pinocchio_contenders, kdl_contenders, mujoco_contenders}) {
        for (auto &contender : make(model)) {
            all.push_back(std::move(contender));
        }
    }
    bool is_found = mode != "run";
    for (auto &contender : all) {
        if (mode == "check") {
            check(*contender, model);
        } else if (mode == "time") {
            time(*contender, model, count);
        } else if (contender->name() == argv[4]) {
            contender->set(model.start_rad.data());
            contender->ticks(count);
            is_found = true;
        }
    }
    if (!is_found) {
        std::fprintf(stderr, "ticks: NAME '%s': expected a name that `check` prints\n", argv[4]);
        return 2;
    }
    return 0;
}
