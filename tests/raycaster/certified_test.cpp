// The certified search against the reference caster, on fields that ray casters miss: no stretch
// inside longer than the guarantee is missed, no hit is false, and each is the first.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "hard_fields.h"
#include "raycaster/reference.h"
#include "raycaster/renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <sstream>

namespace isocast {
namespace {

using namespace test;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

/// What a picture is of, and by which filter.
struct Subject {
    std::string name;
    std::shared_ptr<const FieldSource> samples;
    Filter filter = Filter::BSpline;
    double iso = 0;
    StorageOptions storage;
    double storage_error = 0;

    Kernel kernel() const { return kernel_of(filter); }
};

/// A field whose control samples are those given, so that the B-spline is what it says.
Subject subject_of(const HardField& field, Filter filter = Filter::BSpline) {
    return {.name = field.name, .samples = field.control, .filter = filter};
}

/// The steps of the reference [voxels]: half the guarantee, so that it sees what must be seen.
constexpr double reference_step = 0.005;
constexpr double guarantee = 0.01;

/// The truth about a subject, and how far float32 may be off.
class Oracle {
public:
    explicit Oracle(const Subject& subject)
        : control_(control_samples(subject.samples, subject.filter)),
          subject_(subject), options_{.kernel = subject.kernel(), .step_voxels = reference_step},
          exact_(*control_, subject.iso, options_) {
        const IndexBox extent = control_->extent();
        // Greatest |sample - iso| that a point of the surface reads, and the greatest slope there.
        for_each_sample({extent.lo, (extent.hi.array() - 1).matrix()}, [&](const Index3& cell) {
            const Index3 lo = (cell.array() - 1).matrix();
            const auto support = copied(*control_, {lo, (lo.array() + 4).matrix()});
            const auto [min, max] = std::ranges::minmax(support);
            if (min > subject.iso || max < subject.iso) return;
            magnitude_ = std::max({magnitude_, subject.iso - min, max - subject.iso});
        });
    }

    const FieldSource& control() const { return *control_; }

    /// To be called with slopes at the reference's hits before the errors are asked for.
    void see_slope(double slope) { slope_ = std::max(slope_, slope); }
    bool has_seen_slope() const { return slope_ > 0; }

    /// How far an evaluated value may lie from f at a hit's place in double:
    /// 2^-20 of the samples, sixteen roundings of a sum of 64 products (twice that for Catmull-Rom,
    /// whose weights' sizes add up to 1.25 along each axis, 1.95 in all), what the storage says,
    /// and a displacement of 3e-5 voxel: coordinates of up to 200 voxels before the middle is taken
    /// off round by 1e-5 along each axis, and the search ends within 1e-5.
    double value_error() const {
        const double weights = subject_.filter == Filter::CatmullRom ? 1.96 : 1;
        return weights * (0x1p-20 * magnitude_ + subject_.storage_error) + 3e-5 * slope_;
    }
    /// The casters of the surfaces that lie value_error() inside and outside.
    void prepare() {
        deep_.clear();
        for (const double sign : {-1.0, 1.0})
            deep_.emplace_back(*control_, subject_.iso + sign * value_error(), options_);
    }

    std::optional<double> first_root(const Ray& ray) const { return exact_.hit(ray); }
    double value(const Vec3d& p_index) const { return exact_.value(p_index); }
    double slope(const Vec3d& p_index, const Vec3d& direction_index) const {
        return kernel_jet(*control_, p_index, subject_.kernel()).gradient.dot(direction_index);
    }

    /// Where a unit ray is sure to be stopped at the latest: it enters a stretch longer than the
    /// guarantee in which the value has the other sign by more than its error.
    ///
    /// t_end  where the ray leaves the extent
    std::optional<double> first_certain(const Ray& ray, bool starts_inside, double t_end) const {
        // From outside f falls below iso - error, from inside it rises above iso + error.
        const ReferenceCaster& deep = deep_[starts_inside ? 1 : 0];
        const auto next = [&](double t) -> std::optional<double> {
            const auto hit =
                deep.hit({ray.origin_world + t * ray.direction_world, ray.direction_world});
            return hit ? std::optional(t + *hit) : std::nullopt;
        };
        // 1e-9: past a root that is known to 1e-12.
        for (auto enter = next(0); enter;) {
            const double exit = next(*enter + 1e-9).value_or(t_end);
            // 1e-4: places of float32, as above.
            if (exit - *enter > guarantee + 1e-4) return enter;
            if (exit + 1e-9 >= t_end) return std::nullopt;
            enter = next(exit + 1e-9);
        }
        return std::nullopt;
    }

private:
    std::shared_ptr<const FieldSource> control_;
    Subject subject_;
    ReferenceOptions options_;
    ReferenceCaster exact_;
    std::vector<ReferenceCaster> deep_;
    double magnitude_ = 0;
    double slope_ = 0;
};

/// Where a ray is in the extent, for t >= 0; x > y if nowhere.
Eigen::Vector2d clip(const Ray& ray, const IndexBox& extent) {
    double t_in = 0;
    double t_out = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = extent.lo[axis] - ray.origin_world[axis];
        const double hi = extent.hi[axis] - 1 - ray.origin_world[axis];
        if (ray.direction_world[axis] == 0) {
            if (lo > 0 || hi < 0) return {1, 0};
            continue;
        }
        const double t0 = lo / ray.direction_world[axis];
        const double t1 = hi / ray.direction_world[axis];
        t_in = std::max(t_in, std::min(t0, t1));
        t_out = std::min(t_out, std::max(t0, t1));
    }
    return {t_in, t_out};
}

/// What became of a picture's rays.
struct Verdict {
    int hits = 0;        // of the picture
    int certain = 0;     // rays that must be stopped
    int transversal = 0; // whose first root is certain and known to 1e-3 voxel
    int missed = 0;
    int late = 0; // stopped after where they must have been
    int false_hits = 0;
    int misplaced = 0;
    double worst_voxels = 0; // of transversal ones
    std::string example;     // of what went wrong

    Verdict& operator+=(const Verdict& other) {
        hits += other.hits;
        certain += other.certain;
        transversal += other.transversal;
        missed += other.missed;
        late += other.late;
        false_hits += other.false_hits;
        misplaced += other.misplaced;
        worst_voxels = std::max(worst_voxels, other.worst_voxels);
        if (example.empty()) example = other.example;
        return *this;
    }
    bool is_right() const { return missed + late + false_hits + misplaced == 0; }
};

std::ostream& operator<<(std::ostream& out, const Verdict& v) {
    return out << v.hits << " hits, " << v.certain << " certain, " << v.transversal
               << " transversal, " << v.missed << " missed, " << v.late << " late, " << v.false_hits
               << " false, " << v.misplaced << " misplaced, worst " << v.worst_voxels << "; "
               << v.example;
}

/// Unit rays, since voxels here are of unit size and world is index space.
Ray unit_ray(const Camera& camera, int size, int x, int y) {
    Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
    ray.direction_world.normalize();
    return ray;
}

Verdict judge_pixel(const Oracle& oracle, const Camera& camera, const Image& image, int x, int y) {
    const float* hit = image.pixel(x, y);
    const bool is_hit = hit[3] != 0;
    Verdict out;
    const Ray ray = unit_ray(camera, image.width, x, y);
    const Vec3d& d = ray.direction_world;
    const Eigen::Vector2d range = clip(ray, oracle.control().extent());
    const double t_in = range.x();
    const double t_out = range.y();
    const Vec3d p_hit = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
    const double t_hit = (p_hit - ray.origin_world).dot(d);
    const auto report = [&](int& count, const std::string& what) {
        ++count;
        std::ostringstream text;
        text.precision(9);
        text << what << " at pixel " << x << ", " << y << ": hit " << (is_hit ? t_hit : -1) << ", "
             << "extent " << t_in << " to " << t_out << ", root "
             << oracle.first_root(ray).value_or(-1) << ", f there "
             << (is_hit ? oracle.value(p_hit) : 0) << ", error " << oracle.value_error();
        out.example = text.str();
    };
    if (is_hit) {
        ++out.hits;
        // On its ray, in the extent, and on the surface. 1e-4: as in first_certain.
        const bool is_on_ray =
            (p_hit - ray.origin_world - t_hit * d).norm() < 1e-4 && t_hit > -1e-4;
        const bool is_on_surface = std::abs(oracle.value(p_hit)) <= oracle.value_error();
        if (!is_on_ray || !is_on_surface || t_hit < t_in - 1e-4 || t_hit > t_out + 1e-4)
            report(out.false_hits, "false");
    }
    if (!(t_in <= t_out)) return out;
    const double value_before = oracle.value(ray.origin_world + t_in * d);
    // Where the ray starts on the surface it may be taken for either side.
    if (std::abs(value_before) <= oracle.value_error()) return out;
    const auto certain = oracle.first_certain(ray, value_before < 0, t_out);
    if (!certain) return out;
    ++out.certain;
    if (!is_hit) {
        report(out.missed, "missed");
        return out;
    }
    const double t_root = oracle.first_root(ray).value_or(*certain);
    const double slope = std::abs(oracle.slope(ray.origin_world + t_root * d, d));
    // To first order the error of the value over the slope, on each side of the root.
    const double tolerance = 1e-5 + 2 * oracle.value_error() / slope;
    if (t_hit > *certain + 1e-4 + tolerance) report(out.late, "late");
    // The first root opens that stretch, and it is transversal.
    if (tolerance > 1e-3 || *certain - t_root > 1e-3) return out;
    // A root before it can be one that the reference's steps passed; it was checked above.
    if (t_hit < t_root - 1e-3) return out;
    ++out.transversal;
    out.worst_voxels = std::abs(t_hit - t_root);
    if (out.worst_voxels > 1e-3) report(out.misplaced, "misplaced");
    return out;
}

struct Certified : testing::Test {
    std::unique_ptr<gl::Context> context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer{*context, shader_folder};

    void load(const Subject& subject) {
        renderer.load({.field = subject.samples,
                       .iso_world = subject.iso,
                       .filter = subject.filter,
                       .storage = subject.storage,
                       .quality = {.guarantee_voxels = guarantee}});
    }
    Image draw(const Camera& camera, int size) {
        renderer.draw(camera, size, size, {FrameImage::Hit});
        return renderer.read(FrameImage::Hit);
    }

    /// Draws the pictures and judges every pixel.
    Verdict judge(const Subject& subject, const std::vector<Camera>& cameras, int size = 64) {
        load(subject);
        Oracle oracle(subject);
        // Slopes at a few of the roots, before anything is judged by them.
        for (const Camera& camera : cameras) {
            for (int y = 0; y < size; y += 3) {
                for (int x = 0; x < size; x += 3) {
                    const Ray ray = unit_ray(camera, size, x, y);
                    const auto t = oracle.first_root(ray);
                    if (!t) continue;
                    const Vec3d p = ray.origin_world + *t * ray.direction_world;
                    oracle.see_slope(
                        kernel_jet(oracle.control(), p, subject.kernel()).gradient.norm());
                }
            }
        }
        oracle.prepare();
        Verdict sum;
        std::mutex mutex;
        for (const Camera& camera : cameras) {
            const Image image = draw(camera, size);
            tbb::parallel_for(0, size, [&](int y) {
                Verdict row;
                for (int x = 0; x < size; ++x) row += judge_pixel(oracle, camera, image, x, y);
                const std::lock_guard lock(mutex);
                sum += row;
            });
        }
        EXPECT_TRUE(sum.is_right())
            << subject.name << ", " << filter_name(subject.filter) << ": " << sum;
        RecordProperty(subject.name, (std::ostringstream{} << sum).str());
        return sum;
    }
};

/// From outside the cube [0, n)^3, perspective and orthographic, no axis along the view.
std::vector<Camera> oblique_cameras(int n, unsigned seed, int count) {
    Random random(seed);
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i) {
        const Vec3d middle = Vec3d::Constant(0.5 * (n - 1));
        Camera camera{.eye_world = middle + 3 * n * random_point(random, -1, 1).normalized(),
                      .target_world = middle,
                      .up = random_point(random, -1, 1)};
        camera.height_world = 1.3 * n;
        if (i % 2 == 1) camera.projection = Projection::Orthographic;
        cameras.push_back(camera);
    }
    return cameras;
}

/// Along each axis, orthographic: every ray has two components that are zero.
std::vector<Camera> axis_cameras(int n) {
    std::vector<Camera> cameras;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3d middle = Vec3d::Constant(0.5 * (n - 1));
        cameras.push_back({.eye_world = middle + (axis == 1 ? -2 * n : 2 * n) * Vec3d::Unit(axis),
                           .target_world = middle,
                           .up = Vec3d::Unit((axis + 1) % 3),
                           .projection = Projection::Orthographic,
                           .height_world = 1.0 * n});
    }
    return cameras;
}

TEST_F(Certified, NothingIsMissedFromOutside) {
    constexpr int n = 32;
    for (unsigned seed = 1; seed <= 2; ++seed) {
        for (const HardField& field : hard_fields(n, seed)) {
            const Verdict v = judge(subject_of(field), oblique_cameras(n, seed, 4));
            // Tests test something: most of the rays that hit had to.
            EXPECT_GT(v.certain, 500) << field.name;
            EXPECT_GT(v.certain, 0.9 * v.hits) << field.name;
        }
    }
}

TEST_F(Certified, NothingIsMissedAlongTheAxes) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 3)) {
        const Verdict v = judge(subject_of(field), axis_cameras(n));
        EXPECT_GT(v.certain, 300) << field.name;
    }
}

TEST_F(Certified, NothingIsMissedOfASheetSeenEdgeOn) {
    constexpr int n = 32;
    const ThinSheet sheet = thin_sheet(n, 4);
    Random random(4);
    std::vector<Camera> cameras;
    // In the sheet's plane or 0.1 to 0.001 voxel above it, and looking along it or nearly so.
    for (const double height : {0.0, 0.001, 0.02, 0.1}) {
        const Vec3d along = sheet.normal.cross(random_point(random, -1, 1)).normalized();
        cameras.push_back({.eye_world = sheet.p_on_sheet + 60 * along + height * sheet.normal,
                           .target_world = sheet.p_on_sheet,
                           .up = sheet.normal,
                           .fov_y_degrees = height == 0 ? 1.0 : 10.0});
    }
    const Verdict v = judge(subject_of(sheet.field), cameras);
    EXPECT_GT(v.certain, 4000);
}

TEST_F(Certified, NothingIsMissedOfATorusSeenEdgeOn) {
    constexpr int n = 48;
    const Vec3d centre(23.3, 23.9, 23.6);
    const Vec3d axis = Vec3d(0.2, -0.3, 1).normalized();
    const AnalyticField torus = torus_field(centre, axis, 16, 2.5);
    const auto control = control_of(n, [&](const Vec3d& p) { return torus.jet(p).value; });
    const Vec3d along = axis.cross(Vec3d(1, 2, 3)).normalized();
    std::vector<Camera> cameras;
    // At the heights of the tube's top, where rays graze it for long, of its middle and between.
    for (const double height : {0.0, 1.5, 2.4, 2.49, 2.5, 2.51})
        cameras.push_back({.eye_world = centre + 100 * along + height * axis,
                           .target_world = centre + height * axis,
                           .up = axis,
                           .projection = Projection::Orthographic,
                           .height_world = 0.5});
    cameras.push_back({.eye_world = centre + 100 * along,
                       .target_world = centre,
                       .up = axis,
                       .fov_y_degrees = 25});
    for (const Filter filter : {Filter::BSpline, Filter::Interpolating}) {
        const Verdict v =
            judge({.name = "torus edge-on", .samples = control, .filter = filter}, cameras, 48);
        EXPECT_GT(v.certain, 3000);
    }
}

TEST_F(Certified, NothingIsMissedOfWhiteNoise) {
    Random random(5);
    const auto field =
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(24)}));
    for (const Filter filter :
         {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom}) {
        const Verdict v = judge({.name = "white noise", .samples = field, .filter = filter},
                                oblique_cameras(24, 5, 2));
        EXPECT_GT(v.certain, 1000);
    }
}

TEST_F(Certified, RaysThatEnterTheFieldInsideTheObjectSeeNoSurfaceThere) {
    // Rounding once put the place where they enter into a block beyond the field, whose sign was
    // that of its page's first sample.
    for (unsigned seed = 11; seed <= 14; ++seed) {
        const Verdict v = judge(subject_of(smooth_noise(40, seed)), oblique_cameras(40, seed, 2));
        EXPECT_GT(v.certain, 3000);
    }
}

TEST_F(Certified, NothingIsMissedByTheOtherFilters) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 6)) {
        for (const Filter filter :
             {Filter::Linear, Filter::CatmullRom, Filter::Interpolating, Filter::Exact}) {
            std::vector<Camera> cameras = oblique_cameras(n, 6, 2);
            cameras.push_back(axis_cameras(n)[0]);
            judge(subject_of(field, filter), cameras);
        }
    }
}

TEST_F(Certified, EyesInsideTheObjectAndInsideActiveBlocks) {
    constexpr int n = 32;
    for (const HardField& field : hard_fields(n, 7)) {
        Random random(7);
        const Subject subject = subject_of(field);
        const ReferenceCaster caster(*field.control, 0, {.step_voxels = reference_step});
        std::vector<Camera> cameras;
        while (cameras.size() < 8) {
            const Ray ray = random_ray(random, n);
            const auto t = caster.hit(ray);
            if (!t) continue;
            // Before the surface, and as deep behind it as the thinnest part allows; a tenth of it,
            // or a thousandth of a voxel, so that the start's side is certain.
            const double half = std::clamp(field.thickness_voxels / 2, 0.0, 1.0);
            const double offset = cameras.size() % 4 == 0   ? -1.7
                                  : cameras.size() % 4 == 1 ? -0.05
                                  : half > 0                ? half
                                                            : 0.5;
            const Vec3d eye = ray.origin_world + (*t + offset) * ray.direction_world;
            Camera camera{.eye_world = eye,
                          .target_world = eye + random_point(random, -1, 1),
                          .up = random_point(random, -1, 1),
                          .fov_y_degrees = 120};
            if (cameras.size() % 2 == 1) camera.target_world = eye + ray.direction_world;
            cameras.push_back(camera);
        }
        const Verdict v = judge(subject, cameras, 32);
        EXPECT_GT(v.certain, 500) << field.name;
    }
}

TEST_F(Certified, PlateausAtTheIsoValueShowWhatIsNegativeOnly) {
    for (const double iso : {0.0, 0.375}) {
        const auto plateau = [&](auto value) {
            return control_of(24, [&](const Vec3d& p) { return iso + value(p); });
        };
        for (const Filter filter :
             {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom}) {
            std::vector<Camera> cameras = oblique_cameras(24, 8, 2);
            cameras.push_back(axis_cameras(24)[2]);
            cameras.push_back({.eye_world = {11.3, 12.1, 17.5}, .target_world = {11, 12, 5}});
            const Subject flat{.name = "flat",
                               .samples = plateau([](const Vec3d&) { return 0.0; }),
                               .filter = filter,
                               .iso = iso};
            load(flat);
            for (const Camera& camera : cameras) {
                for (const float value : draw(camera, 32).rgba) ASSERT_EQ(value, 0);
            }
            // Nowhere negative. Catmull-Rom and the interpolating control samples undershoot beside
            // a kink, which is then a surface.
            const Subject above{.name = "flat and above",
                                .samples = plateau([](const Vec3d& p) {
                                    return std::max(0.0, (p.z() - 12.0) / 4);
                                }),
                                .filter = filter,
                                .iso = iso};
            load(above);
            const bool undershoots =
                filter == Filter::CatmullRom || filter == Filter::Interpolating;
            if (!undershoots) {
                for (const Camera& camera : cameras) {
                    for (const float value : draw(camera, 32).rgba) ASSERT_EQ(value, 0);
                }
            }
            judge(above, cameras, 32);
            // Negative below z = 12, from there on flat.
            const Verdict v = judge({.name = "flat and below",
                                     .samples = plateau([](const Vec3d& p) {
                                         return std::min(0.0, (p.z() - 12.0) / 4);
                                     }),
                                     .filter = filter,
                                     .iso = iso},
                                    cameras, 32);
            EXPECT_GT(v.hits, 500) << filter_name(filter);
        }
    }
}

TEST_F(Certified, RaysInTheFacesBetweenBlocksMeetTheNearestSurfaceFirst) {
    // A slab over the plane where the ray's parameter is zero, which once split rays that run in a
    // face: the half behind it was in the upper block and came first.
    for (int axis = 0; axis < 3; ++axis) {
        const auto control =
            control_of(48, [&](const Vec3d& p) { return std::abs(p[axis] - 29.6) - 5; });
        for (const double sign : {-1.0, 1.0}) {
            for (const Projection projection :
                 {Projection::Perspective, Projection::Orthographic}) {
                // One pixel: zero components are exact. Faces along both other axes, or along one.
                for (const double offset : {0.0, 3.0}) {
                    Vec3d middle = Vec3d::Constant(16);
                    middle[(axis + 1) % 3] += offset;
                    const Camera camera{.eye_world = middle + 64 * sign * Vec3d::Unit(axis),
                                        .target_world = middle,
                                        .up = Vec3d::Unit((axis + 1) % 3),
                                        .projection = projection,
                                        .height_world = 1};
                    const Verdict v = judge({.name = "slab", .samples = control}, {camera}, 1);
                    EXPECT_EQ(v.hits, 1);
                }
            }
        }
    }
}

/// Expects the same bits. Returns how many pixels hit.
int expect_identical(const Image& a, const Image& b) {
    int hits = 0;
    int different = 0;
    double greatest = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        different += a.rgba[i] != b.rgba[i];
        greatest = std::max(greatest, double(std::abs(a.rgba[i] - b.rgba[i])));
        hits += i % 4 == 3 && a.rgba[i] != 0;
    }
    EXPECT_EQ(different, 0) << "by up to " << greatest;
    return hits;
}

TEST_F(Certified, PicturesDoNotDependOnHowSamplesAreStored) {
    constexpr int n = 40;
    for (const HardField& field : {tilted_torus(n, 9), smooth_noise(n, 9)}) {
        for (const Filter filter : {Filter::Linear, Filter::Interpolating, Filter::CatmullRom}) {
            for (const SampleFormat format :
                 {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16}) {
                for (const Camera& camera : oblique_cameras(n, 9, 2)) {
                    Subject subject = subject_of(field, filter);
                    subject.storage.format = format;
                    load(subject);
                    const Image expected = draw(camera, 48);
                    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
                        for (const int brick_size : {8, 16, 32}) {
                            subject.storage = {fetch, format, brick_size};
                            load(subject);
                            SCOPED_TRACE(std::string(filter_name(filter)) + " " + field.name +
                                         ", fetch " + std::to_string(int(fetch)) + ", format " +
                                         std::to_string(int(format)) + ", bricks of " +
                                         std::to_string(brick_size));
                            EXPECT_GT(expect_identical(draw(camera, 48), expected), 100);
                        }
                    }
                }
            }
        }
    }
}

TEST_F(Certified, PicturesDoNotDependOnTheNumberOfThreads) {
    const Subject subject = subject_of(smooth_noise(48, 10), Filter::Interpolating);
    const Camera camera = oblique_cameras(48, 10, 1)[0];
    const auto picture = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        load(subject);
        return draw(camera, 96);
    };
    EXPECT_GT(expect_identical(picture(1), picture(2)), 1000);
}

TEST_F(Certified, StorageInSixteenBitsErrsByWhatItSays) {
    constexpr int n = 40;
    for (const HardField& field : {tilted_torus(n, 11), smooth_noise(n, 11)}) {
        for (const Filter filter : {Filter::Linear, Filter::Interpolating, Filter::CatmullRom}) {
            for (const SampleFormat format : {SampleFormat::Float16, SampleFormat::Norm16}) {
                Subject subject = subject_of(field, filter);
                subject.storage.format = format;
                const auto control = control_samples(subject.samples, filter);
                const BlockRanges ranges = find_block_ranges(*control, subject.kernel());
                const FieldOnGpu on_gpu(*subject.samples, *control, subject.kernel(), ranges,
                                        active_pages(ranges, 0), 0, subject.storage, {});
                subject.storage_error = on_gpu.pool().storage_error();
                // 2^-11 of the greatest value, and a step of 2^-15 halved.
                EXPECT_GT(subject.storage_error, 0);
                EXPECT_LT(subject.storage_error, 0x1p-10 * on_gpu.pool().greatest_value());
                const Verdict v = judge(subject, oblique_cameras(n, 11, 2));
                EXPECT_GT(v.certain, 1000);
            }
        }
    }
}

} // namespace
} // namespace isocast
