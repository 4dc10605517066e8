//! The collected scans: counts and coordinates as other programs read them, and
//! broken files.
//!
//! The expected values were read by laspy 2.7 with laszip 0.3 (LAS and LAZ), pye57 0.4
//! (E57), pypcd4 1.5 (PCD), plyfile 1.1 (PLY), and a few lines of numpy (text and PTX).

use std::fs;
use std::path::{Path, PathBuf};

use formats::points::ScanGrid;
use formats::{Points, read_points};

/// What another program reads from a file.
struct Expected {
    path: &'static str,
    points: usize,
    not_finite: u64,
    /// Rows and columns of the first scan.
    grid: Option<(usize, usize)>,
    first: [f64; 3],
    last: [f64; 3],
    /// The sum of all coordinates.
    sum: f64,
}

/// Sums in another order differ in their last digits. pypcd4 rounds the numbers
/// of ascii PCD to 24 bits, where we keep their digits.
const TOLERANCE: f64 = 1e-7;

#[rustfmt::skip]
const EXPECTED: [Expected; 60] = [
    Expected { path: "C/agisoft_rgb.xyz", points: 100, not_finite: 0, grid: None, first: [665187.522077, 5648349.895035, 241.767693], last: [665186.236769, 5648351.141146, 244.871176], sum: 631377665.442713 },
    Expected { path: "C/b9_labels.ply.gz", points: 22300, not_finite: 0, grid: None, first: [596732.4375, 243629.125, 76.76165008544922], last: [596697.8125, 243629.640625, 88.83897399902344], sum: 18742029420.911903 },
    Expected { path: "C/bun0_normals.pcd", points: 397, not_finite: 0, grid: None, first: [0.005421599838882685, 0.11349000036716461, 0.040748998522758484], last: [-0.07793000340461731, 0.1751600056886673, -0.04439999908208847], sum: 40.04684499144787 },
    Expected { path: "C/bunny397.pcd", points: 397, not_finite: 0, grid: None, first: [0.0054216, 0.11349, 0.040749], last: [-0.07793, 0.17516, -0.0444], sum: 40.046845042 },
    Expected { path: "C/bunny_10scans_points.ply.gz", points: 181136, not_finite: 0, grid: None, first: [-0.06324999779462814, 0.03597930073738098, 0.04208730161190033], last: [-0.013169999234378338, 0.18435710668563843, -0.02720949426293373], sum: 15376.942312894844 },
    Expected { path: "C/bunny_freecad.asc", points: 397, not_finite: 0, grid: None, first: [0.0054216, 0.11349, 0.040749], last: [-0.07793, 0.17516, -0.0444], sum: 40.046845042 },
    Expected { path: "C/bunny_part1.xyz.gz", points: 20702, not_finite: 0, grid: None, first: [-3.73, -0.78, 12.79], last: [-5.07, -0.48, 14.42], sum: 70234.55 },
    Expected { path: "C/car_cloud400.csv.gz", points: 24989, not_finite: 0, grid: None, first: [-3.5376, 0.639553, -1.37678], last: [-0.0559087, 1.29374, 6.64353], sum: 119054.9445058911 },
    Expected { path: "C/chef_normals.pcd", points: 5092, not_finite: 0, grid: None, first: [-0.04479869827628136, -0.04188179969787598, -0.6955410242080688], last: [-0.09560160338878632, -0.0060056098736822605, -0.5885570049285889], sum: -3357.0363248811345 },
    Expected { path: "C/colored_column.pcd", points: 1000, not_finite: 0, grid: None, first: [-0.8550515174865723, -0.6315085887908936, 1.4670000076293945], last: [0.2712914049625397, -0.3860686123371124, 0.9129999876022339], sum: 477.81300576706417 },
    Expected { path: "C/dragon1.xyz.gz", points: 100000, not_finite: 0, grid: None, first: [3.1798, 5.0338, 5.6575], last: [4.377, -2.0292, 7.9644], sum: 1070869.2615 },
    Expected { path: "C/elephant.pwn.gz", points: 10000, not_finite: 0, grid: None, first: [-0.24443, 0.43515, -0.21067], last: [0.011901, 0.25599, 0.19306], sum: -118.546138133 },
    Expected { path: "C/kinect_capture1.pcd.gz", points: 249647, not_finite: 57553, grid: Some((480, 640)), first: [-1.4948029518127441, -1.1952769756317139, 2.9670000076293945], last: [0.845280110836029, 0.681119978427887, 1.5119999647140503], sum: 554105.7542771681 },
    Expected { path: "C/kinect_face0.pcd", points: 1397, not_finite: 0, grid: None, first: [-0.15264999866485596, 0.03880000114440918, 0.6909999847412109], last: [-0.06683749705553055, 0.16218750178813934, 0.7909998893737793], sum: 1009.6253109909594 },
    Expected { path: "C/kinect_person.pcd.gz", points: 242749, not_finite: 64451, grid: Some((480, 640)), first: [-1.8632090091705322, -1.3139209747314453, 3.2769999504089355], last: [0.7212753295898438, 0.6071894764900208, 1.3309999704360962], sum: 537085.0322290708 },
    Expected { path: "C/lamppost.pcd", points: 1771, not_finite: 0, grid: None, first: [-10.0, 0.0, 0.0], last: [-9.828125, 0.0625, -5.420997619628906], sum: -21561.757083892822 },
    Expected { path: "C/lidar_samp11_ground.pcd", points: 21786, not_finite: 0, grid: None, first: [512743.625, 5403547.5, 308.67999267578125], last: [512834.75, 5403811.5, 370.45001220703125], sum: 128904056573.09952 },
    Expected { path: "C/milk_rgba.pcd", points: 12575, not_finite: 0, grid: None, first: [0.18544159829616547, -0.0062090009450912476, -0.706432580947876], last: [0.32187381386756897, -0.04479962959885597, -0.6667013764381409], sum: -6837.714675854353 },
    Expected { path: "C/oni_normals.xyz", points: 1435, not_finite: 0, grid: None, first: [-0.120621, -0.048544, -0.228788], last: [0.230974, -0.411741, -0.210068], sum: 255.464297 },
    Expected { path: "C/pond_photogrammetry.ply.gz", points: 70051, not_finite: 0, grid: None, first: [1.1775000095367432, 0.8752350211143494, -1.2355600595474243], last: [-1.4876400232315063, 0.8931699991226196, -0.34720098972320557], sum: 37830.36696256971 },
    Expected { path: "C/rangegrid_bun270.ply.gz", points: 31701, not_finite: 0, grid: Some((400, 512)), first: [-0.02525000087916851, 0.03471510112285614, 0.04348680004477501], last: [-0.017000000923871994, 0.1876010000705719, 0.019152000546455383], sum: 5519.2984494159755 },
    Expected { path: "C/rangegrid_dragon072.ply.gz", points: 14879, not_finite: 0, grid: Some((272, 370)), first: [0.011934599839150906, 0.05308179929852486, 0.06501439958810806], last: [0.010408700443804264, 0.1974560022354126, -0.03764659911394119], sum: 2629.530010627099 },
    Expected { path: "C/rops_cloud.pcd.gz", points: 32087, not_finite: 0, grid: None, first: [0.13057999312877655, 0.2487100064754486, -1.173200011253357], last: [0.3310199975967407, -0.24030999839305878, -1.0973999500274658], sum: -39709.80607134512 },
    Expected { path: "D/ply_int_coords.ply", points: 16, not_finite: 0, grid: None, first: [-409.0, 249.0, 4.0], last: [-797.0, 517.0, 8.0], sum: -3357.0 },
    Expected { path: "D/ply_list_element_points.ply", points: 5, not_finite: 0, grid: None, first: [-0.06324999779462814, 0.03597930073738098, 0.04208730161190033], last: [-0.06350000202655792, 0.03672889992594719, 0.04246620088815689], sum: 0.07290790602564812 },
    Expected { path: "D/points-prim.obj", points: 8, not_finite: 0, grid: None, first: [0.0, 2.0, 2.0], last: [2.0, 2.0, 0.0], sum: 24.0 },
    Expected { path: "E/ply_points_bin.ply", points: 8, not_finite: 0, grid: None, first: [1.0, 1.0, 1.0], last: [1.0, 1.0, -1.0], sum: 0.0 },
    Expected { path: "clouds/bad/xyz_on_a_line.xyz", points: 1000, not_finite: 0, grid: None, first: [0.0, 0.0, 0.0], last: [999.0, 1998.0, 2997.0], sum: 2997000.0 },
    Expected { path: "clouds/e57/bunny_double.e57", points: 30571, not_finite: 0, grid: None, first: [-0.07063, 0.04015, 0.0012259999999999999], last: [-0.037829, 0.12794, 0.004474], sum: 2574.349416 },
    Expected { path: "clouds/e57/coloured_cube_float.e57", points: 7680, not_finite: 0, grid: None, first: [-0.5, -0.4990559220314026, 0.07136291265487671], last: [0.16827905178070068, -0.00394439697265625, 0.5], sum: -62.450788110494614 },
    Expected { path: "clouds/e57/invalid_state.e57", points: 1, not_finite: 0, grid: None, first: [-1.0, -2.0, -3.0], last: [-1.0, -2.0, -3.0], sum: -6.0 },
    Expected { path: "clouds/e57/normals.e57", points: 2, not_finite: 0, grid: None, first: [1.0, 0.0, 0.0], last: [2.0, 0.0, 0.0], sum: 3.0 },
    Expected { path: "clouds/e57/pump.e57", points: 155201, not_finite: 0, grid: Some((1074, 345)), first: [1.702286, -3.1935879999999996, -1.841843], last: [-1.2676239999999999, -0.7964019999999999, -1.381729], sum: -631025.947105 },
    Expected { path: "clouds/e57/tiny_spherical.e57", points: 180, not_finite: 0, grid: None, first: [1.0, 0.0, 0.0], last: [0.9996376326769216, -0.019032498863828545, 0.01903594817912861], sum: 204.60113076925293 },
    Expected { path: "clouds/e57/two_scans_moved.e57", points: 6, not_finite: 0, grid: None, first: [-42.63949966430664, 1.8725999593734741, 0.666700005531311], last: [-44.11943817138672, 0.7053028345108032, -0.607699990272522], sum: -250.66033402085304 },
    Expected { path: "clouds/las/gps_time_nan.las", points: 1, not_finite: 0, grid: None, first: [0.0, 0.0, 0.0], last: [0.0, 0.0, 0.0], sum: 0.0 },
    Expected { path: "clouds/las/interesting.las", points: 1065, not_finite: 0, grid: None, first: [637012.24, 849028.31, 431.66], last: [637342.85, 853240.3200000001, 423.92], sum: 1585764095.66 },
    Expected { path: "clouds/las/mvk_thin.las", points: 6280, not_finite: 0, grid: None, first: [2045008.1700000002, 1272222.6400000001, 106.61], last: [2049988.1400000001, 1267517.93, 108.12], sum: 20834893083.84 },
    Expected { path: "clouds/las/sample_thin.las", points: 2732, not_finite: 0, grid: None, first: [674522.0000134277, 1206771.7500170898, 627.590029296875], last: [674601.4300134277, 1206784.2700170898, 653.310029296875], sum: 5141604972.463413 },
    Expected { path: "clouds/las/version_1_4.las", points: 1000, not_finite: 0, grid: None, first: [1694510.3869346841, 1816497.966263977, 5598.3596128149675], last: [1694291.6363326558, 1816493.0662305846, 5597.089652537912], sum: 3516472463.760168 },
    Expected { path: "clouds/laz/autzen_trim.laz", points: 110000, not_finite: 0, grid: None, first: [637177.98, 849393.9500000001, 411.19], last: [636037.88, 849336.9400000001, 423.2], sum: 163473478103.62 },
    Expected { path: "clouds/laz/lone_star_split1.laz", points: 122893, not_finite: 0, grid: None, first: [515396.148, 4918348.30075, 2323.8455], last: [515393.8595, 4918363.07975, 2337.573], sum: 668057161758.4745 },
    Expected { path: "clouds/laz/old_compressor_1_2r0.laz", points: 1065, not_finite: 0, grid: None, first: [637012.24, 849028.31, 431.66], last: [637342.85, 853240.3200000001, 423.92], sum: 1585764095.66 },
    Expected { path: "clouds/laz/point_time_color.laz", points: 1065, not_finite: 0, grid: None, first: [494428.61, 4877455.58, 131.57], last: [494490.24, 4878741.67, 129.21], sum: 5721991325.24 },
    Expected { path: "clouds/pcd/bunny_ascii_normals.pcd", points: 397, not_finite: 0, grid: None, first: [0.005421599838882685, 0.11349000036716461, 0.040748998522758484], last: [-0.07793000340461731, 0.1751600056886673, -0.04439999908208847], sum: 40.04684499144787 },
    Expected { path: "clouds/pcd/horse_ascii.pcd", points: 3400, not_finite: 0, grid: None, first: [-34.17911148071289, 86.84940338134766, 137.89639282226562], last: [34.14707565307617, 87.21350860595703, 138.0484619140625], sum: 406552.4778791319 },
    Expected { path: "clouds/pcd/milk_colour_compressed.pcd", points: 13704, not_finite: 0, grid: None, first: [-0.13160760700702667, -0.2095429003238678, 0.7720000147819519], last: [0.013806669972836971, -0.18820670247077942, 0.7630000114440918], sum: 7965.647921721509 },
    Expected { path: "clouds/pcd/object_template_padding_field.pcd", points: 1397, not_finite: 0, grid: None, first: [-0.15264999866485596, 0.03880000114440918, 0.6909999847412109], last: [-0.06683749705553055, 0.16218750178813934, 0.7909998893737793], sum: 1009.6253109909594 },
    Expected { path: "clouds/pcd/person_organised_compressed.pcd", points: 242749, not_finite: 64451, grid: Some((480, 640)), first: [-1.8632090091705322, -1.3139209747314453, 3.2769999504089355], last: [0.7212753295898438, 0.6071894764900208, 1.3309999704360962], sum: 537085.0322290708 },
    Expected { path: "clouds/pcd/terrain_utm_f32.pcd", points: 22474, not_finite: 0, grid: None, first: [494198.53125, 5420712.0, 259.8299865722656], last: [494648.0, 5420583.0, 291.94000244140625], sum: 132940923791.36624 },
    Expected { path: "clouds/ply/bun000_range_grid.ply", points: 40256, not_finite: 0, grid: Some((400, 512)), first: [-0.06324999779462814, 0.03597930073738098, 0.04208730161190033], last: [-0.017999999225139618, 0.18794000148773193, -0.01972530037164688], sum: 4355.531505424373 },
    Expected { path: "clouds/ply/duplicates_cloud.ply", points: 5395, not_finite: 0, grid: None, first: [-0.4999982758680142, -0.387929624966736, -0.1724131985751773], last: [0.4999982758680142, 0.3879297686215619, 0.22413715814773053], sum: -694.6092862508526 },
    Expected { path: "clouds/pts/autzen.pts", points: 10, not_finite: 0, grid: None, first: [636110.300003, 849345.050003, 512.139999], last: [636125.87999, 848971.060013, 428.050003], sum: 14856448.760070002 },
    Expected { path: "clouds/pts/bun000_half.pts", points: 10063, not_finite: 0, grid: None, first: [-0.06275, 0.036034, 0.042595], last: [-0.01575, 0.187201, -0.022021], sum: 1089.1128 },
    Expected { path: "clouds/pts/test.pts", points: 19, not_finite: 0, grid: None, first: [3.980972, -2.006119, -0.010086], last: [-19.501053, -24.533554, -1.533951], sum: -787.807878 },
    Expected { path: "clouds/ptx/bun000_half.ptx", points: 10063, not_finite: 0, grid: Some((107, 157)), first: [-0.09475, 0.122609, 0.023447], last: [0.06025, 0.069011, 0.016031], sum: 1089.1128 },
    Expected { path: "clouds/ptx/colour.ptx", points: 1065, not_finite: 0, grid: Some((71, 15)), first: [637012.24, 849028.31, 431.66], last: [637342.85, 853240.32, 423.92], sum: 1585764095.66 },
    Expected { path: "clouds/ptx/two_scans_transform.ptx", points: 8, not_finite: 0, grid: Some((2, 2)), first: [637012.24, 849028.31, 431.66], last: [636699.38, 848991.01, 425.39], sum: 11890673.04 },
    Expected { path: "clouds/xyz/diamond.xyz", points: 6, not_finite: 0, grid: None, first: [0.5, 0.0, 0.5], last: [0.5, 0.5, 1.0], sum: 9.0 },
    Expected { path: "clouds/xyz/horse.xyz", points: 3400, not_finite: 0, grid: None, first: [-34.179111, 86.849403, 137.896393], last: [34.147076, 87.213509, 138.048462], sum: 406552.47789 },
];

/// Files that are refused, and why.
const REFUSED: [(&str, &str); 11] = [
    ("C/chameleon4k.pts", "is binary"),
    ("clouds/bad/pcd_ascii_ragged.pcd", "has not 3 values"),
    ("clouds/bad/pcd_compressed_bad_backref.pcd", "do not unpack"),
    ("clouds/bad/pcd_compressed_sizes_4g.pcd", "unpacks to"),
    ("clouds/bad/pcd_count_big_padding.pcd", "points of"),
    ("clouds/bad/pcd_no_data_line.pcd", "no DATA line"),
    ("clouds/bad/pcd_size_3.pcd", "size 3"),
    ("clouds/bad/ply_no_faces_list_huge.ply", "ends after 0 of the 1 rows"),
    ("clouds/bad/ptx_all_missing.ptx", "all 9 are missing"),
    ("clouds/bad/ptx_singular_matrix.ptx", "places nothing"),
    ("clouds/bad/xyz_ragged.csv", "2 of 3 lines"),
];

/// The folder of collected scans. Says so if this checkout has none beside it.
fn scans() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scans");
    let found = folder.join("clouds/INDEX.tsv").is_file();
    if !found {
        eprintln!("SKIPPED: the collected scans (../../shared/scans) are not there");
    }
    found.then_some(folder)
}

/// What differs from the other program.
fn differences(cloud: &Points, expected: &Expected) -> Vec<String> {
    let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * b.abs().max(1e-3);
    let near3 = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| near(*a, b));
    let last = cloud.len() - 1;
    let sum: f64 = (0..cloud.len()).flat_map(|i| cloud.absolute(i)).sum();
    let grid = cloud.scans[0].grid.as_ref();
    let found = grid.map(|grid| (grid.rows, grid.columns));
    let filled = grid.map(|grid| grid.cells.iter().filter(|&&c| c != ScanGrid::EMPTY).count());
    let wrong = [
        (cloud.len() != expected.points, format!("{} points", cloud.len())),
        (cloud.lost.not_finite != expected.not_finite, format!("{:?}", cloud.lost)),
        (found != expected.grid, format!("a grid of {found:?}")),
        (filled.is_some_and(|n| n != cloud.scans[0].points.len()), format!("{filled:?} cells")),
        (!near3(cloud.absolute(0), expected.first), format!("first {:?}", cloud.absolute(0))),
        (!near3(cloud.absolute(last), expected.last), format!("last {:?}", cloud.absolute(last))),
        (!near(sum, expected.sum), format!("a sum of {sum:?}, not {:?}", expected.sum)),
    ];
    wrong.into_iter().filter(|(wrong, _)| *wrong).map(|(_, what)| what).collect()
}

#[test]
fn collected_clouds_read_as_by_other_programs() {
    let Some(folder) = scans() else { return };
    let mut wrong = Vec::new();
    for expected in &EXPECTED {
        match read_points(&folder.join(expected.path)) {
            Ok(cloud) => {
                let differences = differences(&cloud, expected);
                wrong.extend(differences.iter().map(|what| format!("{}: {what}", expected.path)));
                println!(
                    "{}: {:?} {:?} {:?}",
                    expected.path, cloud.origin, cloud.lost, cloud.notes
                );
            }
            Err(error) => wrong.push(format!("refused: {error}")),
        }
    }
    for (path, word) in REFUSED {
        match read_points(&folder.join(path)) {
            Ok(_) => wrong.push(format!("{path}: is read")),
            Err(error) if !error.to_string().contains(word) => wrong.push(error.to_string()),
            Err(error) => println!("{error} ({})", error.help),
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The broken scans, and meshes, which are no clouds.
#[test]
fn broken_files_are_survived() {
    let Some(folder) = scans() else { return };
    for list in ["clouds/bad", "D", "E"] {
        for entry in fs::read_dir(folder.join(list)).expect("a folder of scans") {
            let path = entry.expect("an entry").path();
            match read_points(&path) {
                Ok(cloud) => println!("{}: {} points", path.display(), cloud.len()),
                Err(error) => assert!(error.help.ends_with('.'), "no help in: {error}"),
            }
        }
    }
}
