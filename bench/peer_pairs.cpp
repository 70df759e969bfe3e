// Mesh against mesh in coal or fcl (compiled with -DPEER_COAL or -DPEER_FCL), driven by commands on standard input as
// `extricate-bench serve` is; nothing is timed but the library's own calls.
//
//   load NAME FILE.off            {"triangles", "build_seconds", "bytes"}
//   time A B POSES LIMIT [OUT]    {"seconds", "count", "hits"}; LIMIT is coal's security margin, fcl takes 0 only
#include <time.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

// Of this thread on a processor: what other programs do meanwhile is not in it.
static double now() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec + 1e-9 * time.tv_nsec;
}

struct Soup {
  std::vector<double> points;
  std::vector<int> faces;
};

#ifdef PEER_COAL
#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
using Mesh = coal::BVHModel<coal::OBBRSS>;

static std::shared_ptr<Mesh> build(const Soup& soup) {
  std::vector<coal::Vec3s> points;
  std::vector<coal::Triangle> faces;
  for (size_t k = 0; k < soup.points.size(); k += 3) points.emplace_back(soup.points[k], soup.points[k + 1], soup.points[k + 2]);
  for (size_t k = 0; k < soup.faces.size(); k += 3) faces.emplace_back(soup.faces[k], soup.faces[k + 1], soup.faces[k + 2]);
  auto mesh = std::make_shared<Mesh>();
  mesh->beginModel(faces.size(), points.size());
  mesh->addSubModel(points, faces);
  mesh->endModel();
  return mesh;
}

// As pinocchio uses it: one functor a pair, so that the lookup of the function is not timed.
struct Pair {
  coal::ComputeCollision check;
  coal::CollisionRequest request;
  coal::CollisionResult result;
  Pair(const Mesh& a, const Mesh& b, double limit) : check(&a, &b) {
    request.num_max_contacts = 1;
    request.enable_contact = false;
    request.security_margin = limit;
  }
  bool operator()(const coal::Transform3s& pose) {
    result.clear();
    return check(coal::Transform3s(), pose, request, result) > 0;
  }
};
using Pose = coal::Transform3s;
static Pose pose(const double* n) {
  coal::Matrix3s r;
  r << n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8];
  return Pose(r, coal::Vec3s(n[9], n[10], n[11]));
}
#else
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
using Mesh = fcl::BVHModel<fcl::OBBRSSd>;

static std::shared_ptr<Mesh> build(const Soup& soup) {
  std::vector<fcl::Vector3d> points;
  std::vector<fcl::Triangle> faces;
  for (size_t k = 0; k < soup.points.size(); k += 3) points.emplace_back(soup.points[k], soup.points[k + 1], soup.points[k + 2]);
  for (size_t k = 0; k < soup.faces.size(); k += 3) faces.emplace_back(soup.faces[k], soup.faces[k + 1], soup.faces[k + 2]);
  auto mesh = std::make_shared<Mesh>();
  mesh->beginModel(faces.size(), points.size());
  mesh->addSubModel(points, faces);
  mesh->endModel();
  return mesh;
}

struct Pair {
  const Mesh &a, &b;
  fcl::CollisionRequestd request;
  fcl::CollisionResultd result;
  Pair(const Mesh& first, const Mesh& second, double limit) : a(first), b(second) {
    if (limit != 0) throw std::runtime_error("fcl's boolean knows no margin");
    request.num_max_contacts = 1;
    request.enable_contact = false;
  }
  bool operator()(const fcl::Transform3d& pose) {
    result.clear();
    return fcl::collide(&a, fcl::Transform3d::Identity(), &b, pose, request, result) > 0;
  }
};
using Pose = fcl::Transform3d;
static Pose pose(const double* n) {
  Pose p = Pose::Identity();
  p.linear() << n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8];
  p.translation() << n[9], n[10], n[11];
  return p;
}
#endif

static long resident() {
  std::ifstream status("/proc/self/status");
  std::string word;
  long kib = 0;
  while (status >> word)
    if (word == "VmRSS:") status >> kib;
  return kib * 1024;
}

static Soup read(const std::string& path) {
  std::ifstream file(path);
  std::string off;
  size_t points = 0, faces = 0, edges = 0;
  if (!(file >> off >> points >> faces >> edges) || off != "OFF") throw std::runtime_error(path + ": no OFF file");
  Soup soup;
  soup.points.resize(3 * points);
  soup.faces.resize(3 * faces);
  for (double& x : soup.points) file >> x;
  for (size_t k = 0; k < faces; k++) {
    int corners;
    file >> corners >> soup.faces[3 * k] >> soup.faces[3 * k + 1] >> soup.faces[3 * k + 2];
  }
  if (!file) throw std::runtime_error(path + ": the file ends early");
  return soup;
}

static std::vector<Pose> poses(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<Pose> all;
  double numbers[12];
  while (file.read(reinterpret_cast<char*>(numbers), sizeof numbers)) all.push_back(pose(numbers));
  return all;
}

int main() {
  std::map<std::string, std::shared_ptr<Mesh>> meshes;
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string command, a, b, path, out;
    words >> command;
    try {
      if (command == "load") {
        words >> a >> path;
        Soup soup = read(path);
        long before = resident();
        auto start = now();
        auto mesh = build(soup);
        double seconds = now() - start;
        std::printf("{\"triangles\": %zu, \"build_seconds\": %.9g, \"bytes\": %ld}\n", soup.faces.size() / 3, seconds, resident() - before);
        meshes[a] = mesh;
      } else if (command == "time") {
        double limit = 0;
        words >> a >> b >> path >> limit >> out;
        auto all = poses(path);
        Pair pair(*meshes.at(a), *meshes.at(b), limit);
        std::string answers(all.size(), '\0');
        for (size_t k = 0; k < all.size() / 10; k++) pair(all[k]);
        auto start = now();
        for (size_t k = 0; k < all.size(); k++) answers[k] = pair(all[k]);
        double seconds = now() - start;
        size_t hits = 0;
        for (char hit : answers) hits += hit;
        if (!out.empty()) std::ofstream(out, std::ios::binary) << answers;
        std::printf("{\"seconds\": %.9g, \"count\": %zu, \"hits\": %zu}\n", seconds, all.size(), hits);
      } else {
        throw std::runtime_error("got `" + command + "`, expected load or time");
      }
    } catch (const std::exception& error) {
      std::printf("{\"error\": \"%s\"}\n", error.what());
    }
    std::fflush(stdout);
  }
}
