// Nothing public of the C++ API is forgotten in the C API: members of World, and fields of structs.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace pierce {
namespace {

namespace fs = std::filesystem;

const fs::path root = PIERCE_SOURCE_FOLDER;

std::string text_of(const fs::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string without_comments(const std::string& text) {
    return std::regex_replace(text, std::regex(R"(//[^\n]*|/\*([^*]|\*[^/])*\*/)"), "");
}

std::string cpp_header(const std::string& name) {
    const std::string text = without_comments(text_of(root / "src/core/include/pierce" / name));
    EXPECT_FALSE(text.empty()) << name;
    return text;
}

/// pierce.h and all that it includes.
std::string c_headers() {
    std::string all;
    const fs::path folder = root / "src/c_api/include";
    const std::string main = text_of(folder / "pierce/pierce.h");
    static const std::regex included("#include \"([^\"]+)\"");
    for (std::sregex_iterator at(main.begin(), main.end(), included), end; at != end; ++at)
        all += text_of(folder / (*at)[1].str());
    return without_comments(all);
}

/// What stands between the braces after `head`.
std::string body_after(const std::string& text, const std::string& head) {
    std::size_t at = text.find(head);
    EXPECT_NE(at, std::string::npos) << head;
    if (at == std::string::npos) return {};
    at = text.find('{', at);
    int depth = 0;
    std::size_t end = at;
    do {
        depth += text[end] == '{';
        depth -= text[end] == '}';
        ++end;
    } while (depth > 0 && end < text.size());
    return text.substr(at + 1, end - at - 2);
}

/// A text without what stands in braces in it.
std::string outermost(const std::string& text) {
    std::string left;
    int depth = 0;
    for (const char c : text) {
        depth -= c == '}';
        if (depth == 0 && c != '}') left += c;
        depth += c == '{';
        if (depth == 1 && c == '{') left.back() = ' ';
        if (c == '}' && depth == 0) left += ' ';
    }
    return left;
}

TEST(WholeApiTest, EveryMemberOfWorldHasACall) {
    // Named otherwise, or without a counterpart.
    const std::map<std::string, std::string> exceptions{
        {"World", "pierce_create_world"},  // a constructor, and the destructor
        {"operator", ""},                  // a pointer is moved by copying it
        {"unique_ptr", ""},                // of a parameter
        {"default", ""},
    };
    std::string members = body_after(cpp_header("world.hpp"), "class World {");
    members = members.substr(0, members.find("private:"));
    const std::string c = c_headers();
    static const std::regex member(R"((\w+)\((?!\)\s*\())");
    std::set<std::string> names;
    for (std::sregex_iterator at(members.begin(), members.end(), member), end; at != end; ++at)
        names.insert((*at)[1]);
    EXPECT_GT(names.size(), 45u);
    for (const std::string& name : names) {
        const auto other = exceptions.find(name);
        const std::string call = other == exceptions.end() ? "pierce_" + name : other->second;
        EXPECT_TRUE(call.empty() || c.find(" " + call + "(") != std::string::npos)
            << "World::" << name << " has no " << call << "() in pierce.h";
    }
}

/// The names of a struct's data members.
std::vector<std::string> fields(const std::string& body) {
    // Braces hold values that a member is made with.
    const std::string flat = outermost(body);
    std::vector<std::string> names;
    static const std::regex statement("[^;]+;"), methods(R"(\(|\busing\b|\benum\b|\bfriend\b)"),
        declarator(R"((\w+)\s*(\[[^\]]*\])*\s*(=[^,;]*)?[,;])");
    for (std::sregex_iterator at(flat.begin(), flat.end(), statement), end; at != end; ++at) {
        static const std::regex arguments("<[^;]*>");
        const std::string one = std::regex_replace(at->str(), arguments, "");
        if (std::regex_search(one, methods)) continue;
        for (std::sregex_iterator name(one.begin(), one.end(), declarator); name != end; ++name)
            names.push_back((*name)[1]);
    }
    return names;
}

struct Counterpart {
    std::string header, cpp, c;
    std::set<std::string> without;  ///< fields that are not in the struct of C
    std::size_t least;              ///< as many fields are found at least
};

TEST(WholeApiTest, EveryFieldOfAStructIsThere) {
    const std::string c = c_headers();
    // The plan's flags say the same as its stages. A report has the traits and the box in fields
    // of its own.
    const std::set<std::string> flags{
        "moving", "measures_deformation", "casts_rays",    "traces_own_exits", "meets_itself",
        "sheets", "feature_bits",         "velocity_rays", "margins",          "reprojects"};
    const std::vector<Counterpart> all{
        {"settings.hpp", "struct Settings {", "pierce_settings", {}, 10},
        {"step_stats.hpp", "struct StepStats {", "pierce_step_stats", {}, 36},
        {"body.hpp", "struct Collision {", "pierce_collision", {}, 4},
        {"filter.hpp", "struct Filter {", "pierce_filter", {}, 4},
        {"contact.hpp", "Contact {", "pierce_contact", {}, 25},
        {"impact_contact.hpp", "struct ImpactContact {", "pierce_impact", {}, 10},
        {"overlap.hpp", "struct ContactPatch {", "pierce_contact_patch", {}, 6},
        {"overlap.hpp", "struct Overlap {", "pierce_common_volume", {}, 7},
        {"parting.hpp", "struct Parting {", "pierce_translation", {}, 2},
        {"explain.hpp", "struct Explanation {", "pierce_explanation", {}, 7},
        {"plan.hpp", "struct PlannedPart {", "pierce_planned_part", {}, 6},
        {"plan.hpp", "struct Plan {", "pierce_plan_info", flags, 19},
        {"mesh.hpp", "struct MeshOptions {", "pierce_mesh_options", {}, 4},
        {"mesh.hpp", "struct MeshTraits {", "pierce_mesh_info", {}, 6},
        {"inside.hpp", "struct MeshInside {", "pierce_mesh_info", {"rule"}, 8},
        {"mesh_check.hpp", "struct MeshCheckOptions {", "pierce_mesh_check_options", {}, 2},
        {"mesh_check.hpp", "struct MeshReport {", "pierce_mesh_report", {"traits", "box"}, 8},
        {"world.hpp", "struct RayHit {", "pierce_ray_hit", {}, 4},
        {"world.hpp", "struct ProbeContact {", "pierce_probe_contact", {}, 4},
        {"world.hpp", "struct WorldOffsets {", "pierce_offsets", {}, 3},
        {"contact_reduction.hpp", "struct ReducedContact {", "pierce_reduced_contact", {}, 2},
        {"device_contacts.hpp", "struct DeviceContactList {", "pierce_device_contact_list", {}, 11},
    };
    for (const Counterpart& one : all) {
        SCOPED_TRACE(one.cpp);
        const auto names = fields(body_after(cpp_header(one.header), one.cpp));
        EXPECT_GE(names.size(), one.least);
        const auto of_c = fields(body_after(c, "typedef struct " + one.c + " {"));
        const std::set<std::string> there(of_c.begin(), of_c.end());
        for (const std::string& name : names)
            EXPECT_TRUE(there.contains(name) || one.without.contains(name))
                << one.c << " has no " << name;
    }
}

TEST(WholeApiTest, EveryValueOfAnEnumerationIsThere) {
    const std::string c = c_headers();
    const std::vector<std::array<std::string, 3>> all{
        {"settings.hpp", "enum class Temporal", "pierce_temporal"},
        {"settings.hpp", "enum class Coverage", "pierce_coverage"},
        {"body.hpp", "enum class Motion", "pierce_motion"},
        {"body.hpp", "enum class SelfCollision", "pierce_self_collision"},
        {"inside.hpp", "enum class Inside", "pierce_inside"},
        {"contact.hpp", "enum class Found", "pierce_found"},
        {"explain.hpp", "enum class Reason", "pierce_reason"},
        {"explain.hpp", "enum Kind", "pierce_certificate"},
        {"mesh_defect.hpp", "enum class MeshDefect", "pierce_mesh_defect"},
        {"tree_builder.hpp", "enum class TreeBuilder", "pierce_tree_builder"},
    };
    for (const auto& [header, cpp, name] : all) {
        const std::string body = body_after(cpp_header(header), cpp);
        const std::string of_c = body_after(c, "typedef enum " + name + " {");
        static const std::regex value(R"((\w+)\s*(,|$))");
        std::size_t values = 0;
        for (std::sregex_iterator at(body.begin(), body.end(), value), end; at != end; ++at) {
            ++values;
            std::string upper;
            for (const char letter : (*at)[1].str())
                upper += static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
            EXPECT_NE(of_c.find("_" + upper + " ="), std::string::npos) << name << ": " << upper;
        }
        EXPECT_GE(values, 3u) << cpp;
    }
}

}  // namespace
}  // namespace pierce
