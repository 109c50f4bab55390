// How the pierce command behaves: it shows progress, is quiet, stops well, completes, explains
// itself.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>
#include <vector>

#include "support/command.hpp"
#include "support/terminal.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr char escape = '\x1b';

std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class MannersTest : public AppTest {
protected:
    /// Names of files that were begun and not finished.
    std::vector<std::string> parts() const {
        std::vector<std::string> found;
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (entry.path().filename().string().find(".part-") != std::string::npos)
                found.push_back(entry.path());
        return found;
    }

    void write_boxes() const {
        for (const auto& [name, shift] : {std::pair("a.obj", 0.0), std::pair("b.obj", 0.9)}) {
            std::ofstream out(folder / name);
            for (int v = 0; v < 8; ++v)
                out << "v " << (v & 1) + shift << " " << (v >> 1 & 1) + shift / 2 << " "
                    << (v >> 2) + shift / 3 << "\n";
            out << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        }
    }
};

TEST_F(MannersTest, CtrlCLeavesWholeFilesOfTheFramesThatAreDone) {
    OnTerminal run(
        "run tori --count 30 --seconds 600 --json run.json --html page.html "
        "--record motion --png last.png",
        folder);
    ASSERT_TRUE(run.wait_for("simulating [")) << run.text();
    EXPECT_THAT(run.text(), HasSubstr(" left"));
    run.press_ctrl_c();
    EXPECT_EQ(run.end(), 130) << run.text();
    std::smatch stop;
    const std::regex line(
        "pierce: stopped after (\\d+) of 36000 frames: motion, run.json, "
        "page.html hold these frames only");
    ASSERT_TRUE(std::regex_search(run.text(), stop, line)) << run.text();
    const auto frames = std::stoul(stop[1]);
    EXPECT_GT(frames, 0u);

    const json written = read("run.json");
    EXPECT_EQ(written["frames"].size(), frames);
    EXPECT_EQ(written["settings"]["stopped"], "after " + stop[1].str() + " of 36000 frames");
    EXPECT_TRUE(text_of(folder / "page.html").ends_with("</html>\n"));
    EXPECT_THAT(text_of(folder / "last.png"), HasSubstr("IEND"));
    const Outcome replay = pierce("replay motion --json replay.json", folder);
    EXPECT_EQ(replay.code, 0) << replay.text;
    EXPECT_EQ(read("replay.json")["frames"].size(), frames);
    EXPECT_THAT(parts(), testing::IsEmpty());

    // Brute force takes its time: the motion must not end before the signal comes.
    ASSERT_EQ(pierce("run tori --count 30 --seconds 3 --record long", folder).code, 0);
    OnTerminal again(
        "replay long --backend reference --json again.json --html again.html "
        "--coverage complete --temporal off",
        folder);
    ASSERT_TRUE(again.wait_for("replaying [")) << again.text();
    again.press_ctrl_c();
    EXPECT_EQ(again.end(), 130);
    EXPECT_THAT(again.text(), HasSubstr("again.json, again.html hold these frames only"));
    EXPECT_LT(read("again.json")["frames"].size(), 180u);
    EXPECT_TRUE(text_of(folder / "again.html").ends_with("</html>\n"));
}

TEST_F(MannersTest, SigtermStopsItToo) {
    OnTerminal run("run tori --count 30 --seconds 600 --json run.json", folder);
    ASSERT_TRUE(run.wait_for("simulating [")) << run.text();
    run.send(SIGTERM);
    EXPECT_EQ(run.end(), 143) << run.text();
    EXPECT_THAT(run.text(), HasSubstr("run.json holds these frames only"));
    EXPECT_FALSE(read("run.json")["frames"].empty());
}

TEST_F(MannersTest, ASecondCtrlCEndsItAtOnceAndLeavesFilesAsTheyWere) {
    fs::create_directories(folder / "motion");
    // Whoever writes to it waits until somebody reads.
    ASSERT_EQ(mkfifo(path("motion/mesh_0.obj").c_str(), 0600), 0);
    std::ofstream(folder / "run.json") << "{\"old\": true}";
    OnTerminal run("run tori --count 10 --seconds 600 --json run.json --record motion", folder);
    ASSERT_TRUE(run.wait_for("simulating [")) << run.text();
    run.press_ctrl_c();
    ASSERT_TRUE(run.wait_for("once more ends it at once")) << run.text();
    ASSERT_TRUE(run.wait_for("colliding pairs")) << run.text();
    run.press_ctrl_c();
    EXPECT_EQ(run.end(), 130);
    EXPECT_THAT(run.text(), HasSubstr("pierce: ended at once"));
    EXPECT_EQ(read("run.json"), json::parse("{\"old\": true}"));
    EXPECT_FALSE(fs::exists(folder / "motion/scene.json")) << "half a recording is none";
}

TEST_F(MannersTest, WhatKeepsNothingEndsAtTheFirstCtrlC) {
    fs::create_directories(folder / "motion");
    ASSERT_EQ(mkfifo(path("motion/scene.json").c_str(), 0600), 0);
    OnTerminal replay("replay motion --json x.json", folder);
    usleep(300'000);
    replay.press_ctrl_c();
    EXPECT_EQ(replay.end(), 130);
    EXPECT_THAT(replay.text(), HasSubstr("pierce: stopped"));
    EXPECT_FALSE(fs::exists(folder / "x.json"));
}

TEST_F(MannersTest, ValidateSaysWhichModesAreMissing) {
    OnTerminal early("validate tori --count 30 --seconds 600 --json early.json", folder);
    ASSERT_TRUE(early.wait_for("simulating [")) << early.text();
    early.press_ctrl_c();
    EXPECT_EQ(early.end(), 130);
    EXPECT_THAT(early.text(), AllOf(HasSubstr("of 36000 (simulating)"),
                                    HasSubstr("what was asked for is missing")));
    EXPECT_FALSE(fs::exists(folder / "early.json"));

    ASSERT_EQ(pierce("run tori --count 60 --seconds 30 --record motion", folder).code, 0);
    OnTerminal validate(
        "validate motion --backends embree,bvh --modes full,walk,certified "
        "--json modes.json --html modes.html",
        folder);
    ASSERT_TRUE(validate.wait_for("validating walk [")) << validate.text();
    validate.press_ctrl_c();
    EXPECT_EQ(validate.end(), 130);
    EXPECT_THAT(validate.text(),
                HasSubstr("missing are the modes walk, certified, and modes.html"));
    const json written = read("modes.json");
    EXPECT_EQ(written["modes"].size(), 1u);
    EXPECT_EQ(written["settings"]["missing_modes"], json({"walk", "certified"}));
}

TEST_F(MannersTest, CompareAndExplainSayWhatIsMissing) {
    ASSERT_EQ(pierce("run tori --count 60 --seconds 12 --record motion", folder).code, 0);
    OnTerminal compare("compare motion --json compare.json", folder);
    ASSERT_TRUE(compare.wait_for("truth [")) << compare.text();
    compare.press_ctrl_c();
    EXPECT_EQ(compare.end(), 130);
    EXPECT_THAT(compare.text(), HasSubstr("stopped while making the truth"));
    EXPECT_FALSE(fs::exists(folder / "motion/truth.json"));
    EXPECT_FALSE(fs::exists(folder / "compare.json"));

    OnTerminal explain(
        "explain motion --frame 700 --bodies 1 0 --vertex 7 --json why.json "
        "--backend reference",
        folder);
    ASSERT_TRUE(explain.wait_for("replaying [")) << explain.text();
    explain.press_ctrl_c();
    EXPECT_EQ(explain.end(), 130);
    EXPECT_THAT(explain.text(),
                AllOf(HasSubstr("of 701 (replaying)"), HasSubstr("what was asked for is missing")));
    EXPECT_THAT(parts(), testing::IsEmpty());
}

TEST_F(MannersTest, AReportThatWasStoppedIsClosedAndSaysWhatIsMissing) {
    OnTerminal report("report accuracy --count 30 --seconds 600 --out report", folder);
    ASSERT_TRUE(report.wait_for("simulating tori [")) << report.text();
    report.press_ctrl_c();
    EXPECT_EQ(report.end(), 130) << report.text();
    const std::string markdown = text_of(folder / "report/report.md");
    EXPECT_THAT(markdown, HasSubstr("these parts are missing, or not complete: tori, bunnies, soft "
                                    "tori, tear, leaks"));
    EXPECT_TRUE(text_of(folder / "report/report.html").ends_with("</html>\n"));
    EXPECT_THAT(parts(), testing::IsEmpty());
}

TEST_F(MannersTest, ShortWorkShowsNoBar) {
    OnTerminal run("run tori --count 2 --seconds 0.1", folder);
    EXPECT_EQ(run.end(), 0);
    EXPECT_EQ(run.text().find(escape), std::string::npos) << run.text();
}

TEST_F(MannersTest, LinesOfUnknownLengthSayForHowLong) {
    fs::create_directories(folder / "motion");
    ASSERT_EQ(mkfifo(path("a.off").c_str(), 0600), 0);
    OnTerminal check("check a.off", folder);
    EXPECT_TRUE(check.wait_for("checking a.off, 0:01")) << check.text();
    check.press_ctrl_c();
    EXPECT_EQ(check.end(), 130);
}

TEST_F(MannersTest, ThereAreNoColoursAndNoEscapesInAPipe) {
    const Outcome run = pierce("run tori --count 20 --seconds 4", folder);
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.text.find(escape), std::string::npos) << run.text;
    setenv("NO_COLOR", "1", 1);
    OnTerminal bar("run tori --count 30 --seconds 600", folder);
    ASSERT_TRUE(bar.wait_for("simulating ["));
    bar.press_ctrl_c();
    bar.end();
    unsetenv("NO_COLOR");
    // The end of the line is cleared; nothing else is asked of the terminal.
    EXPECT_EQ(std::regex_replace(bar.text(), std::regex("\x1b\\[K"), "").find(escape),
              std::string::npos);
}

TEST_F(MannersTest, QuietPrintsErrorsOnly) {
    const std::string run = "run tori --count 2 --seconds 0.1 --json run.json";
    for (const std::string& line : {"-q " + run, run + " -q", "--quiet " + run}) {
        fs::remove(folder / "run.json");
        const Outcome quiet = pierce(line, folder);
        EXPECT_EQ(quiet.code, 0) << line;
        EXPECT_EQ(quiet.text, "") << line;
        EXPECT_EQ(read("run.json")["frames"].size(), 6u);
    }
    expect_refused("-q run tori --count 2 --record /proc/nowhere", "/proc/nowhere/scene.json");
    EXPECT_THAT(pierce("-q run torus", folder).text, HasSubstr("unknown scene"));
    setenv("PIERCE_QUIET", "1", 1);
    const Outcome by_environment = pierce("run tori --count 2 --seconds 0.1", folder);
    EXPECT_THAT(pierce("scenes", folder).text, HasSubstr("tori")) << "it is what was asked for";
    EXPECT_THAT(pierce("completion bash", folder).text, HasSubstr("pierce"));
    setenv("PIERCE_QUIET", "0", 1);
    const Outcome not_quiet = pierce("scenes", folder);
    unsetenv("PIERCE_QUIET");
    EXPECT_EQ(by_environment.text, "");
    EXPECT_THAT(not_quiet.text, HasSubstr("tori"));

    const Outcome piped = pierce("-q run tori --count 2 --seconds 0.1 --json /dev/stdout", folder);
    EXPECT_EQ(json::parse(piped.text)["frames"].size(), 6u) << "and nothing else";

    OnTerminal long_one("-q run tori --count 30 --seconds 30", folder);
    EXPECT_EQ(long_one.end(), 0);
    EXPECT_EQ(long_one.text(), "") << "no bar";
}

TEST_F(MannersTest, FilesTakeTheirPlaceAsAWhole) {
    std::ofstream(folder / "real.json") << "old";
    fs::permissions(folder / "real.json", fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("real.json", folder / "link.json");
    const std::string run = "run tori --count 2 --seconds 0.1 --json ";
    ASSERT_EQ(pierce(run + "link.json", folder).code, 0);
    EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
    EXPECT_EQ(read("real.json")["frames"].size(), 6u);
    EXPECT_EQ(fs::status(folder / "real.json").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
    fs::create_directory(folder / "later");
    fs::create_symlink("later/real.json", folder / "broken.json");
    ASSERT_EQ(pierce(run + "broken.json --count 0", folder).code, 2);
    EXPECT_TRUE(fs::is_symlink(folder / "broken.json"));
    EXPECT_TRUE(fs::is_empty(folder / "later"));
    ASSERT_EQ(pierce(run + "broken.json", folder).code, 0);
    EXPECT_TRUE(fs::is_symlink(folder / "broken.json"));
    EXPECT_EQ(read("later/real.json")["frames"].size(), 6u);
    EXPECT_EQ(pierce(run + ".", folder).code, 2) << "a folder";
    EXPECT_EQ(pierce(run + "/dev/null", folder).code, 0);
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_THAT(parts(), testing::IsEmpty());
}

/// The command, where no file may be longer than some blocks of 512 or 1024 bytes, as on a full
/// disk. Returns its exit code.
int with_little_room(int blocks, const std::string& arguments, const fs::path& folder) {
    const std::string command = "cd '" + folder.string() + "' && trap '' XFSZ && ulimit -f " +
                                std::to_string(blocks) + " && " + PIERCE_APP + " " + arguments +
                                " > /dev/null 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
}

TEST_F(MannersTest, AFullDiskIsNoSuccess) {
    write_boxes();
    EXPECT_EQ(with_little_room(40, "run tori --count 1 --soft --seconds 0.5 --record r", folder),
              2);
    EXPECT_FALSE(fs::exists(folder / "r/scene.json"));
    EXPECT_EQ(with_little_room(0, "check a.obj --fix fixed.obj", folder), 2);
    EXPECT_EQ(with_little_room(0, "run tori --count 1 --seconds 0.02 --png last.png", folder), 2);
    for (const char* file : {"fixed.obj", "last.png"}) EXPECT_FALSE(fs::exists(folder / file));
    EXPECT_THAT(parts(), testing::IsEmpty());
    if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    EXPECT_EQ(pierce("-q run tori --count 1 --seconds 0.02 --png /dev/full", folder).code, 2);
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
    EXPECT_EQ(pierce("-q check a.obj --fix /dev/full", folder).code, 2);
    for (const char* command : {"scenes", "--version", "--help", "check a.obj"})
        EXPECT_EQ(WEXITSTATUS(std::system(("cd '" + folder.string() + "' && " + PIERCE_APP + " " +
                                           command + " > /dev/full 2> /dev/null")
                                              .c_str())),
                  2)
            << command;
}

TEST_F(MannersTest, AnotherMotionHasAnotherTruth) {
    ASSERT_EQ(pierce("-q run tori --count 2 --seconds 0.1 --record motion", folder).code, 0);
    for (const char* file : {"motion/truth.json", "motion/sheets.json"})
        std::ofstream(folder / file) << "of the first motion";
    ASSERT_EQ(pierce("-q run tori --count 2 --seconds 0.1 --seed 2 --record motion", folder).code,
              0);
    for (const char* file : {"motion/truth.json", "motion/sheets.json"})
        EXPECT_FALSE(fs::exists(folder / file));
}

TEST_F(MannersTest, WhatCannotBeIsNamed) {
    expect_refused("replya motion", "'replya'");
    expect_refused("-q check nothing.obj", "nothing.obj");
    expect_refused("run tori --count 1 --seconds 1e300", "too many time steps");
    expect_refused("run tori --count 1 --seconds 71582788.3", "too many time steps");
    fs::create_directory(folder / "it's");
    std::ofstream(folder / "it's/sweep.json")
        << R"({"format": "pierce-sweep", "version": 1, "command": ["run", "tori", "--seconds",
               "0.02", "--count", "1"], "parameters": {"--seed": [1]}})";
    const Outcome script = pierce("sweep \"it's/sweep.json\" --slurm | bash -n", folder);
    EXPECT_EQ(script.code, 0) << script.text;
    ASSERT_EQ(pierce("-q sweep \"it's/sweep.json\"", folder).code, 0);
    const Outcome done = pierce("sweep \"it's/sweep.json\" --slurm", folder);
    EXPECT_EQ(done.code, 0);
    EXPECT_THAT(done.text, HasSubstr("No run is missing"));
}

TEST_F(MannersTest, ABodyMayBeLeftOutOfTheFirstFrame) {
    ASSERT_EQ(pierce("-q run tori --count 2 --seconds 0.1 --record motion", folder).code, 0);
    std::fstream poses(folder / "motion/body_1.npy",
                       std::ios::in | std::ios::out | std::ios::binary);
    const std::string content = text_of(folder / "motion/body_1.npy");
    const float nothing = std::numeric_limits<float>::quiet_NaN();
    poses.seekp(static_cast<std::streamoff>(content.size() - 6 * 7 * sizeof(float)));
    poses.write(reinterpret_cast<const char*>(&nothing), sizeof nothing);
    poses.close();
    const Outcome replay = pierce("replay motion --json replay.json", folder);
    EXPECT_EQ(replay.code, 0) << replay.text;
    EXPECT_THAT(replay.text, HasSubstr("left out"));
}

TEST_F(MannersTest, APipeGetsAllAtOnce) {
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    const Outcome outcome = pierce(
        "run tori --count 2 --seconds 0.1 --json pipe & cd '" + folder.string() +
            "' && timeout 20 cat pipe > got.json; kill $! 2> /dev/null; wait",
        folder);
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_EQ(read("got.json")["frames"].size(), 6u);
}

TEST_F(MannersTest, HelpListsExitCodesAndVersionListsBackends) {
    const Outcome help = pierce("--help");
    EXPECT_EQ(help.code, 0);
    for (const char* line :
         {"  0    done", "  1    failure", "  2    input that you can mend",
          "  130  stopped by Ctrl-C", "  143  stopped by SIGTERM", "PIERCE_QUIET=1", "-q,--quiet"})
        EXPECT_THAT(help.text, HasSubstr(line));
    const Outcome version = pierce("--version");
    EXPECT_EQ(version.code, 0);
    EXPECT_TRUE(std::regex_search(
        version.text,
        std::regex("^pierce \\d+\\.\\d+\\.\\d+\ncommit +\\S+\nbuild +\\S+, compiler .+\n"
                   "embree +embree \\d.*\nbvh +bvh.*\nreference +reference.*\ncuda +\\S.*")))
        << version.text;
    const Outcome nothing = pierce("check nothing.obj");
    EXPECT_EQ(nothing.code, 2);
}

TEST_F(MannersTest, DoctorSaysWhatThereIsAndWhatIsMissing) {
    const Outcome healthy = pierce("doctor --json doctor.json", folder);
    EXPECT_EQ(healthy.code, 0) << healthy.text;
    EXPECT_THAT(healthy.text, AllOf(HasSubstr("threads"), HasSubstr("memory"), HasSubstr("fmt"),
                                    HasSubstr("self test"), HasSubstr("automatic"),
                                    HasSubstr("all is well"), Not(HasSubstr("WRONG"))));
    const json found = read("doctor.json");
    EXPECT_EQ(found["works"], true);
    ASSERT_EQ(found["backends"].size(), 4u);
    for (const json& backend : found["backends"]) {
        EXPECT_EQ(backend["runs"], backend["problem"] == "") << backend;
        if (backend["runs"] == true) {
            EXPECT_EQ(backend["right"], true) << backend;
            EXPECT_EQ(backend["hash"], found["backends"][0]["hash"]);
        }
    }
    EXPECT_EQ(found["needs"]["truth"]["here"], true);

    setenv("PIERCE_DATA_DIR", "/nowhere", 1);
    setenv("PIERCE_PYTHON", "/nowhere/python", 1);
    const Outcome poor = pierce("doctor", folder);
    unsetenv("PIERCE_DATA_DIR");
    unsetenv("PIERCE_PYTHON");
    EXPECT_EQ(poor.code, 0) << "contacts are found";
    EXPECT_THAT(poor.text, AllOf(HasSubstr("hint: '/nowhere/bunny.off' is missing: install"),
                                 HasSubstr("hint: install python3-matplotlib")));
}

/// What Bash offers where a line ends.
std::vector<std::string> offered(const std::vector<std::string>& words, const fs::path& folder) {
    std::string line;
    for (const std::string& word : words) line += " '" + word + "'";
    std::ofstream(folder / "complete.bash")
        << "source pierce.bash\nCOMP_WORDS=(" << line << ")\nCOMP_CWORD=" << words.size() - 1
        << "\n_pierce\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    std::FILE* pipe = popen(("cd '" + folder.string() + "' && bash complete.bash 2>&1").c_str(),
                            "r");
    std::string text;
    for (char buffer[4096]; const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe);)
        text.append(buffer, n);
    EXPECT_EQ(pclose(pipe), 0) << text;
    std::vector<std::string> found;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word);) found.push_back(word);
    return found;
}

TEST_F(MannersTest, BashCompletesCommandsOptionsChoicesAndFiles) {
    using testing::Contains;
    using testing::ElementsAre;
    using testing::IsSupersetOf;
    ASSERT_EQ(pierce("completion bash > pierce.bash", folder).code, 0);
    fs::create_directories(folder / "motion");
    std::ofstream(folder / "my mesh.obj") << "";
    const auto of = [&](const std::vector<std::string>& words) { return offered(words, folder); };
    EXPECT_THAT(of({"pierce", ""}), IsSupersetOf({"run", "replay", "report", "doctor"}));
    EXPECT_THAT(of({"pierce", "re"}), ElementsAre("replay", "report"));
    EXPECT_THAT(of({"pierce", "--v"}), ElementsAre("--version"));
    EXPECT_THAT(of({"pierce", "report", ""}), ElementsAre("paper", "accuracy", "cloth"));
    EXPECT_THAT(of({"pierce", "report", "paper", "--qui"}), ElementsAre("--quick", "--quiet"));
    EXPECT_THAT(of({"pierce", "run", "tor"}), ElementsAre("tori"));
    EXPECT_THAT(of({"pierce", "-q", "run", "--html"}), ElementsAre("--html", "--html-reasons"));
    EXPECT_THAT(of({"pierce", "run", "tori", "--coverage", ""}),
                ElementsAre("vertices", "overlaps", "complete"));
    EXPECT_THAT(of({"pierce", "run", "tori", "--coverage", "=", "v"}), ElementsAre("vertices"));
    EXPECT_THAT(of({"pierce", "run", "--method", "gim"}), ElementsAre("gimpact"));
    EXPECT_THAT(of({"pierce", "run", "--backend", "e"}), ElementsAre("embree"));
    EXPECT_THAT(of({"pierce", "run", "--seconds", ""}), ElementsAre("")) << "any number";
    EXPECT_THAT(of({"pierce", "compare", "motion", "--methods", "full,gi"}),
                ElementsAre("full,gimpact"));
    EXPECT_THAT(of({"pierce", "check", "my"}), ElementsAre("my mesh.obj"));
    EXPECT_THAT(of({"pierce", "run", "--json", "mo"}), ElementsAre("motion"));
    EXPECT_THAT(of({"pierce", "replay", ""}), ElementsAre("motion")) << "folders only";
    EXPECT_THAT(of({"pierce", "validate", ""}), IsSupersetOf({"tori", "motion"}));
    EXPECT_THAT(of({"pierce", "completion", ""}), ElementsAre("bash", "zsh", "fish"));
}

TEST_F(MannersTest, ZshAndFishReadTheirScripts) {
    expect_refused("completion tcsh", "tcsh");
    for (const auto& [shell, reports] :
         {std::pair<std::string, const char*>("zsh", "'1:command:(paper accuracy cloth)'"),
          std::pair<std::string, const char*>("fish", " -a accuracy -d ")}) {
        ASSERT_EQ(pierce("completion " + shell + " > script", folder).code, 0);
        EXPECT_THAT(text_of(folder / "script"),
                    AllOf(HasSubstr("validate"), HasSubstr("certified"), HasSubstr(reports)));
        if (std::system(("command -v " + shell + " > /dev/null").c_str()) != 0) continue;
        EXPECT_EQ(std::system((shell + " -n '" + path("script") + "'").c_str()), 0) << shell;
    }
}

/// The lines under "Examples:".
std::vector<std::string> examples_of(const std::string& help) {
    std::vector<std::string> lines;
    std::istringstream in(help.substr(std::min(help.find("Examples:"), help.size())));
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("  pierce ")) lines.push_back(line.substr(9));
    return lines;
}

TEST_F(MannersTest, ExamplesOfEveryHelpRun) {
    std::vector<std::string> commands{"", "report paper", "report accuracy", "report cloth"};
    std::istringstream in(pierce("--help").text);
    bool listed = false;
    for (std::string line; std::getline(in, line) && !line.starts_with("Exit");) {
        if (listed && line.starts_with("  "))
            commands.push_back(line.substr(2, line.find(' ', 2) - 2));
        listed = listed || line.starts_with("Subcommands:");
    }
    ASSERT_GE(commands.size(), 17u);
    std::ofstream(folder / "sweep.json")
        << R"({"format": "pierce-sweep", "version": 1, "command": ["run", "tori", "--count", "2"],
               "parameters": {"--seconds": [0.1, 0.2]}})";
    fs::create_directories(folder / "home/.local/share/bash-completion/completions");
    fs::create_directories(folder / "home/.zsh/completions");
    fs::create_directories(folder / "home/.config/fish/completions");
    const std::string home = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "";
    for (const std::string& command : commands) {
        const Outcome help = pierce(command + " --help");
        EXPECT_EQ(help.code, 0) << command;
        const std::vector<std::string> examples = examples_of(help.text);
        EXPECT_FALSE(examples.empty()) << command;
        for (const std::string& example : examples) {
            write_boxes();
            fs::remove_all(folder / "motion");
            ASSERT_EQ(pierce("run tori --count 3 --seconds 0.2 --record motion", folder).code, 0);
            // What takes long is only read: the file or folder it writes cannot be written.
            std::string line = example, refused;
            if (example.starts_with("report ")) refused = "/proc/nowhere";
            if (example.starts_with("demo")) refused = "/nowhere/demo.png";
            if (example.starts_with("demo")) line = "demo --png " + refused;
            if (example.starts_with("report "))
                line = std::regex_replace(example, std::regex("--out \\w+"), "--out " + refused);
            setenv("HOME", path("home").c_str(), 1);
            const Outcome outcome = pierce(line, folder);
            setenv("HOME", home.c_str(), 1);
            EXPECT_EQ(outcome.code, refused.empty() ? 0 : 2) << example << "\n" << outcome.text;
            EXPECT_THAT(outcome.text, HasSubstr(refused)) << example;
        }
    }
}

}  // namespace
}  // namespace pierce::test
