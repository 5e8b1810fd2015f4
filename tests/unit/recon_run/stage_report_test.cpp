// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/stage_body_map.h"
#include "reconstruction/run/stage_pose_fit.h"
#include "reconstruction/run/stage_report.h"
#include "reconstruction/subject/body/body_truth.h"
#include "sdk/core/percentile.h"
#include "tests/unit/recon_page/module_folder.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

class StageReport : public testing::Test {
protected:
    StageReport() {
        toy_.takePictures(toy_.avatar);
        toy_.avatar.evidence = {{"garment layer: top", true, 0, 0, "12 triangles"}, {"garment layer: hair", false, 0, 0, "not seen"}};
        toy_.package.bytes = bytesOf(toy_.avatar);
        toy_.body.fit.staticPose = toy_.truth[0];
        for (size_t f = 0; f < ToyReconstruction::kFrames; ++f) {
            const ScanFrame& frame = toy_.table.scan.frames[f];
            FramePose pose{frame.name, frame.kind, frame.split, toy_.truth[f], std::nullopt};
            pose.pose.rootTranslation.x += 0.02f;  // the registered pose is 2 cm off
            if (frame.split == Split::Test) pose.fittedPose = toy_.truth[f];
            found_.poses.frames.push_back(pose);
        }
    }
    /** report.json, after a run of the stage. */
    nlohmann::json report() {
        dpl::Run run(toy_.chain, toy_.jobs, toy_.progress);
        toy_.giveTrained(run);
        run.put(mapped_, "map");
        run.put(found_, posesKey_);
        run.put(request_, "request");
        const auto files = run.get<ReportFiles>();
        if (!files) throw std::runtime_error(files.error().message);
        folder_ = (*files)->folder;
        return nlohmann::json::parse(text("report.json"));
    }
    /** A file of that run. */
    std::string text(const char* file) const {
        const auto bytes = must(readFile(folder_ / file));
        return {bytes.begin(), bytes.end()};
    }
    /** Mean masked PSNR of frames, drawn in the given poses. */
    double meanDb(const std::vector<size_t>& frames, const std::function<Pose(size_t)>& poseOf) {
        AvatarView view = must(AvatarView::open(toy_.package.bytes, 2));
        double sum = 0;
        for (const size_t f : frames) {
            const FramePicture picture = must(readFramePicture(toy_.table.scan.frames[f]));
            sum += scorePicture(must(view.draw(poseOf(f), toy_.metric.cameras[f])), picture.image, picture.mask).maskedPsnrDb;
        }
        return sum / double(frames.size());
    }

    ToyReconstruction toy_;
    RunRequest request_;
    FoundPoses found_;
    std::string posesKey_ = "poses";
    MappedBody mapped_{"What to film again, the most helpful first:\n  1. Film the face\n",
                       {{"film_again", nlohmann::json::array({{{"shot", "closeup face"}, {"sentence", "Film the face"}}})},
                        {"places", nlohmann::json::array({{{"name", "the face"}, {"mm_per_pixel", 1.5}, {"pictures", 7}}})}},
                       {},
                       {}};
    std::filesystem::path folder_;
};

TEST_F(StageReport, beginsWithWhatToFilmAgain) {
    const nlohmann::json json = report();
    EXPECT_EQ(json["film_again"], mapped_.advice);
    ASSERT_EQ(json["body_map"].size(), 1u);
    EXPECT_EQ(json["body_map"][0]["place"], "the face");
    EXPECT_EQ(json["body_map"][0]["mm_per_pixel"], 1.5);
    const std::string html = text("report.html");
    const size_t card = html.find("<p><b>Film the face</b></p>");
    EXPECT_LT(card, html.find("Quality on held-out frames"));
}

TEST_F(StageReport, scoresTheHeldOutFramesAndWritesItsFiles) {
    const nlohmann::json json = report();
    std::vector<std::string> names;
    for (const auto& frame : json["frames"]) names.push_back(frame["name"]);
    EXPECT_EQ(names, (std::vector<std::string>{"frame_5", "frame_6", "frame_7"})) << "held-out frames alone";
    const auto registered = [&](size_t f) { return found_.poses.frames[f].pose; };
    const auto fitted = [&](size_t f) { return *found_.poses.frames[f].fittedPose; };
    const auto mean = [&](const char* kind, const char* which) { return json["means"][kind][which]["masked_psnr_db"].get<double>(); };
    EXPECT_NEAR(mean("static", "with_pose_fit"), meanDb({5, 6}, fitted), 1e-9);
    EXPECT_NEAR(mean("static", "without_pose_fit"), meanDb({5, 6}, registered), 1e-9);
    EXPECT_NEAR(mean("dynamic", "with_pose_fit"), meanDb({7}, fitted), 1e-9);
    EXPECT_NEAR(mean("dynamic", "without_pose_fit"), meanDb({7}, registered), 1e-9);
    EXPECT_GT(mean("static", "with_pose_fit"), mean("static", "without_pose_fit") + 3);
    EXPECT_EQ(json["limits"], nlohmann::json({"hair as a layer of its own: not seen"}));

    EXPECT_TRUE(text("report.html").starts_with("<!doctype html>"));
    EXPECT_NE(text("report.html").find("alt=\"error map"), std::string::npos);
    char headline[64];
    std::snprintf(headline, sizeof headline, "masked PSNR %.2f dB", mean("static", "with_pose_fit"));
    EXPECT_NE(text("summary.txt").find(headline), std::string::npos);
}

TEST_F(StageReport, everyFigureHasAKeyOfItsOwn) {
    toy_.body.fit.keypointSigma = 0.01;
    for (const Split split : {Split::Train, Split::Validation, Split::Test})
        for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic})
            toy_.body.fit.residuals.push_back({kind, split, 3, 9, 2, 2, 4});
    const nlohmann::json json = report();
    std::set<std::string> keys;
    for (const char* table : {"above_floors", "figures", "waterfall"})
        for (const auto& figure : json[table]) EXPECT_TRUE(keys.insert(figure["key"]).second) << figure["key"];
    EXPECT_EQ(keys.count(""), 0u);
    for (const char* key : {"above_floor.static", "file.bytes", "training_step.ms", "dynamic.pose_fit", "residual.static.test.p95",
                            "scale.static.at_1.drawn_2.all"})
        EXPECT_EQ(keys.count(key), 1u) << key;
}

TEST_F(StageReport, saysWhatTheRootsOfStillFramesTookUp) {
    // Each still training frame is 2 cm off the shared pose (the fixture) and turned by its own angle.
    double degrees = 0;
    for (FramePose& frame : found_.poses.frames)
        frame.pose.rootTranslation = toy_.truth[0].rootTranslation + Vec3f(0.02f, 0, 0),
        frame.pose.localRotations[0] =
            Quatf(glm::angleAxis(glm::radians(degrees += 0.5), Vec3d(0, 0, 1))) * toy_.truth[0].localRotations[0];
    const nlohmann::json json = report();
    std::map<std::string, double> found;
    for (const auto& figure : json["figures"]) found[figure["key"]] = figure["value"];
    EXPECT_NEAR(found.at("cameras.root_shift"), 20, 0.01);
    std::vector<double> turns;
    for (size_t f = 0; f < found_.poses.frames.size(); ++f)
        if (found_.poses.frames[f].kind == FrameKind::StaticFull && found_.poses.frames[f].split == Split::Train)
            turns.push_back(0.5 * double(f + 1));
    ASSERT_GT(turns.size(), 2u);
    EXPECT_NEAR(found.at("cameras.root_turn"), percentile(turns, 0.5), 0.01);
}

TEST_F(StageReport, endsWithWordsForWhoFilmed) {
    toy_.training.steps = 300;
    const nlohmann::json json = report();
    const std::string words = text("words.txt");
    EXPECT_EQ(words.find(json["in_words"].get<std::string>() + "\nThis is a draft: it was trained for 300 steps"), 0u) << words;
    EXPECT_EQ(words.find("dB"), std::string::npos);
    EXPECT_NE(text("summary.txt").find("bars met"), std::string::npos) << "the figures stay, for --verbose";
    EXPECT_EQ(text("word.txt"), json["word"]);
    EXPECT_NE(text("report.html").find("<p class=verdict>" + json["in_words"].get<std::string>()), std::string::npos);
}

TEST_F(StageReport, warningsOfTheCheckStandUnderWhatToFilmAgain) {
    toy_.table.check = R"({"findings": [{"topic": "blur", "sentence": "3 pictures are soft"}]})";
    report();
    const std::string html = text("report.html");
    EXPECT_LT(html.find("What to film again"), html.find("<li>3 pictures are soft</li>"));
    EXPECT_LT(html.find("<li>3 pictures are soft</li>"), html.find("<details class=engineers>"));
}

TEST_F(StageReport, opensWithThePersonFromTheFront) {
    report();
    const std::string html = text("report.html");
    // The camera of frame 0 looks at the front (+Z).
    EXPECT_LT(html.find("<img alt=\"the avatar, drawn as the camera of frame_0 saw the person\""), html.find("<h1>"));
    EXPECT_GT(text("portrait.jpg").size(), 300u) << "the same, small, for a farm's page";
}

TEST_F(StageReport, comparesWithTheTruthAndSaysWhoseBodyItIs) {
    // The truth of the moving held-out frame is 20 mm beside the fit.
    toy_.body.shaped.keypoints = {{"root", {}, {{0, 1.0f}}}, {"top", {}, {{1, 1.0f}}}};
    toy_.table.scan.keypointNames = {"root", "top"};
    toy_.table.scan.name = "procedural-1";
    nlohmann::json points;
    for (const PosedKeypoint& k : posedKeypoints(toy_.body.shaped, toy_.truth[7], toy_.table.scan.keypointNames))
        points.push_back({k.place.x + 0.02, -k.place.z, k.place.y});  // truth.json is z-up
    const nlohmann::json truth = {{"shape", {{"body", "ball"}}}, {"frames", {{{"name", "frame_7"}, {"keypoints_world", points}}}}};
    ASSERT_TRUE(writeFileAtomically(toy_.table.scan.root / "truth.json", truth.dump()));
    const nlohmann::json json = report();
    size_t figures = 0;
    for (const auto& figure : json["figures"]) {
        if (figure["key"] != "truth.body_fit.keypoints_mean") continue;
        ++figures;
        EXPECT_NEAR(figure["value"].get<double>(), 20, 0.01);
        EXPECT_EQ(figure["bar"]["at_most"], 15);
        EXPECT_FALSE(figure["bar"]["met"]);
    }
    EXPECT_EQ(figures, 1u);
    ASSERT_EQ(json["provenance"].size(), 2u);
    EXPECT_TRUE(json["provenance"][0].get<std::string>().starts_with("Development set:"));
    EXPECT_NE(json["provenance"][1].get<std::string>().find("same body model"), std::string::npos);

    toy_.body.shaped.name = "another";
    toy_.table.scan.name = "toy";
    posesKey_ = "other poses";  // else the stage is reused
    const nlohmann::json other = report();
    ASSERT_EQ(other["provenance"].size(), 1u);
    EXPECT_TRUE(other["provenance"][0].get<std::string>().starts_with("Not of the development set, by its name."));
}

TEST_F(StageReport, thePersonMovesOnceThereIsAModule) {
    const ModuleFolder module;
    module.remove("live-bundle.js");
    request_.options.web = module.path;
    report();
    EXPECT_EQ(text("report.html").find("dpl-avatar"), std::string::npos);
    EXPECT_NE(text("report.html").find("found no web module"), std::string::npos);
    module.write("live-bundle.js", "console.log('alive');");
    report();
    EXPECT_NE(text("report.html").find("id=dpl-avatar>"), std::string::npos) << "the stage runs again by itself";
}

}  // namespace
}  // namespace dpl::test
