// The best chain of CGAL for a cloud of points: outliers are removed, the points are smoothed by
// jets and thinned, and an advancing front makes the triangles. `clouds.py` builds and runs it.
//
//     clouds_cgal POINTS SPACING OUT.ply front|chain
//
// POINTS are float64 triples. `front` makes the triangles of the raw points. The front makes no edge
// that is longer than three times the spacing. The program prints one line of JSON.

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/grid_simplify_point_set.h>
#include <CGAL/jet_smooth_point_set.h>
#include <CGAL/remove_outliers.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Facet = std::array<std::size_t, 3>;

// Refuses triangles with an edge that is too long.
struct Bound {
    double longest;

    template <typename Reconstruction, typename Cell>
    double operator()(const Reconstruction& front, Cell& cell, const int& index) const {
        for (int i = 1; i <= 3; ++i) {
            const Point& p = cell->vertex((index + i) % 4)->point();
            const Point& q = cell->vertex((index + i % 3 + 1) % 4)->point();
            if (CGAL::squared_distance(p, q) > longest * longest) return front.infinity();
        }
        return front.smallest_radius_delaunay_sphere(cell, index);
    }
};

int main(int count, char** arguments) {
    if (count != 5) return 2;
    std::ifstream given(arguments[1], std::ios::binary);
    const double spacing = std::atof(arguments[2]);
    std::vector<Point> points;
    for (double p[3]; given.read(reinterpret_cast<char*>(p), sizeof p);)
        points.emplace_back(p[0], p[1], p[2]);

    const std::clock_t begun = std::clock();
    if (std::string(arguments[4]) == "chain") {
        const auto distance = CGAL::parameters::threshold_percent(100).threshold_distance(2.5 * spacing);
        points.erase(CGAL::remove_outliers<CGAL::Sequential_tag>(points, 8, distance), points.end());
        CGAL::jet_smooth_point_set<CGAL::Sequential_tag>(points, 24);
        points.erase(CGAL::grid_simplify_point_set(points, 0.5 * spacing), points.end());
    }
    std::vector<Facet> facets;
    const Bound bound{3 * spacing};
    CGAL::advancing_front_surface_reconstruction(
        points.begin(), points.end(), std::back_inserter(facets), bound);
    const double seconds = double(std::clock() - begun) / CLOCKS_PER_SEC;

    std::ofstream out(arguments[3], std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
        << facets.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Point& p : points)
        for (double x : {p.x(), p.y(), p.z()}) out.write(reinterpret_cast<char*>(&x), sizeof x);
    for (const Facet& facet : facets) {
        out.put(3);
        for (std::size_t v : facet) {
            const int number = int(v);
            out.write(reinterpret_cast<const char*>(&number), sizeof number);
        }
    }
    double megabytes = 0;
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) megabytes = std::atof(line.c_str() + 6) * 1024 / 1e6;
    std::printf("{\"cpu_s\": %.3f, \"peak_rss_mb\": %.1f}\n", seconds, megabytes);
}
