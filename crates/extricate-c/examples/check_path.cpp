// A check after planning: proves every edge of a path free, says where it first touches, and repairs it.
//
// usage: check_path [SCENE PATH]     PATH has one configuration a line, numbers between blanks or commas
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include <extricate.hpp>

/// Reads the rows of a file; exits if one has not `nq` numbers.
std::vector<double> read(const char* path, std::size_t nq) {
    std::vector<double> rows;
    std::ifstream file(path);
    if (!file) std::fprintf(stderr, "%s: cannot be read\n", path), std::exit(2);
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream numbers(line);
        std::size_t count = 0;
        for (double x; numbers >> x; ++count) rows.push_back(x);
        if ((count == 0 && line.empty()) || (count == nq && numbers.eof())) continue;
        std::fprintf(stderr, "%s: line %zu: got %zu numbers, expected %zu\n", path, number, count, nq);
        std::exit(2);
    }
    return rows;
}

int main(int argc, char** argv) {
    const extricate::Scene scene = argc > 2 ? extricate::Scene(argv[1]) : extricate::Scene::builtin("planar-arm");
    const std::size_t nq = scene.nq();
    const std::vector<double> path = argc > 2 ? read(argv[2], nq) : std::vector<double>{-1.5, 0, 0, 1.5, 0, 0};
    const std::size_t rows = scene.rows_of(path);
    if (rows < 2) return std::fprintf(stderr, "%s: got %zu configurations, expected two or more\n", argv[2], rows), 2;
    const std::size_t edges = rows - 1;
    const extricate::Solver solver(scene);

    const std::vector<ExtricateSegment> segments =
        scene.check_segments({path.data(), edges * nq}, {path.data() + nq, edges * nq});
    const auto first = std::find_if(segments.begin(), segments.end(), [](const auto& segment) { return !segment.is_free; });
    if (first == segments.end()) return std::printf("all %zu edges are proved free\n", edges), 0;
    const auto [a, b] = scene.names(first->pair);
    std::printf("edge %td %s at %.4f of its length: %s and %s\n", first - segments.begin(),
                first->collides ? "collides" : "is not proved", first->at, a.c_str(), b.c_str());

    const extricate::Repaired repaired = solver.repair(path);
    if (!repaired) return std::puts("no free path was found near it"), 1;
    std::printf("repaired: %zu points, at most %.3f from the path, %.3f long in place of %.3f\n", repaired.points().size(),
                repaired.deviation(), repaired.length(), repaired.length_before());
    for (auto q : repaired.points()) {
        for (double x : q) std::printf("%.6f ", x);
        std::printf("\n");
    }
}
