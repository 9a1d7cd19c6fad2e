// Rays through triangles in Embree 3, single rays on one thread. Started by main.rs of this folder, which tells what the
// file holds that is the only argument, and which speaks with it: a line "set mode" asks for one pass over a set of rays,
// mode 0 being Embree's default traversal and 1 its robust one; the answer is "seconds hits sum-of-distances".

#include <embree3/rtcore.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

struct Ray {
    float origin[3], direction[3], t_max;
};

struct Set {
    bool is_shadow;
    std::vector<Ray> rays;
};

static void read(void *to, size_t bytes, FILE *file) {
    if (fread(to, 1, bytes, file) != bytes) {
        fprintf(stderr, "the file of rays is cut off\n");
        exit(1);
    }
}

static uint32_t read_count(FILE *file) {
    uint32_t count;
    read(&count, sizeof count, file);
    return count;
}

static RTCScene build(RTCDevice device, const std::vector<float> &corners, const std::vector<uint32_t> &triangles, bool robust) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, corners.size() / 3);
    memcpy(to, corners.data(), corners.size() * 4);
    to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles.size() / 3);
    memcpy(to, triangles.data(), triangles.size() * 4);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

int main(int count, char **arguments) {
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : nullptr;
    if (!file) {
        fprintf(stderr, "usage: traverse FILE\n");
        return 2;
    }
    std::vector<float> corners(3 * size_t(read_count(file)));
    std::vector<uint32_t> triangles(3 * size_t(read_count(file)));
    std::vector<Set> sets(read_count(file));
    read(corners.data(), corners.size() * 4, file);
    read(triangles.data(), triangles.size() * 4, file);
    for (Set &set : sets) {
        set.is_shadow = read_count(file) != 0;
        set.rays.resize(read_count(file));
        read(set.rays.data(), set.rays.size() * sizeof(Ray), file);
    }
    fclose(file);

    RTCDevice device = rtcNewDevice("threads=1");
    const RTCScene scenes[2] = {build(device, corners, triangles, false), build(device, corners, triangles, true)};
    printf("ready\n");
    fflush(stdout);

    unsigned chosen, mode;
    while (scanf("%u %u", &chosen, &mode) == 2 && chosen < sets.size() && mode < 2) {
        const RTCScene scene = scenes[mode];
        const Set &set = sets[chosen];
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        size_t hits = 0;
        double distance = 0;
        const auto start = std::chrono::steady_clock::now();
        for (const Ray &ray : set.rays) {
            RTCRayHit query;
            query.ray.org_x = ray.origin[0], query.ray.org_y = ray.origin[1], query.ray.org_z = ray.origin[2];
            query.ray.dir_x = ray.direction[0], query.ray.dir_y = ray.direction[1], query.ray.dir_z = ray.direction[2];
            // Not 0: the robust mode counts a hit at its very end, and where a plane's coordinate is 0 rays start in it.
            query.ray.tnear = 1e-20f, query.ray.tfar = ray.t_max, query.ray.time = 0;
            query.ray.mask = ~0u, query.ray.id = 0, query.ray.flags = 0;
            if (set.is_shadow) {
                rtcOccluded1(scene, &context, &query.ray);
                hits += query.ray.tfar < 0;
            } else {
                query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene, &context, &query);
                if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
                    hits += 1;
                    distance += query.ray.tfar;
                }
            }
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        printf("%.9f %zu %.9g\n", seconds.count(), hits, distance);
        fflush(stdout);
    }
    for (const RTCScene scene : scenes) rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
