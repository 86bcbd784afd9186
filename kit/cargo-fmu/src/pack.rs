//! `cargo fmu pack`, also for `xtask`: builds libraries and packs them with their files into FMUs.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};

use fmi_description::{Kind, Version};

use crate::library::UnsupportedType;
use crate::notices::Notices;
use crate::target::{self, Target, Tools};
use crate::workspace::{Package, Source, Workspace};
use crate::{library, licences, reference};
use fmi_description::{Entries, entries};
use fmi_import::platform;
use fmi_import::platform::Platform;

/// The default profile for libraries; see [`profile`].
pub const FMU_PROFILE: &str = "fmu-release";

/// Arguments of cargo for a profile. A library must unwind from a panic, which is caught in its C
/// functions, and has no symbols but those that it exports.
///
/// [`FMU_PROFILE`] needs no entry in the workspace's Cargo.toml. It is `release` with optimisation
/// of the whole program, which takes longest to build and runs fastest.
pub fn profile(name: &str) -> Vec<String> {
    let mut settings = vec!["panic=\"unwind\"", "strip=\"symbols\""];
    if name == FMU_PROFILE {
        settings.extend([
            "inherits=\"release\"",
            "lto=\"fat\"",
            "codegen-units=1",
            "debug-assertions=false",
            "overflow-checks=false",
        ]);
    }
    let settings = settings
        .iter()
        .flat_map(|s| ["--config".to_string(), format!("profile.{name}.{s}")]);
    let name = ["--profile".to_string(), name.to_string()];
    name.into_iter().chain(settings).collect()
}

/// The platforms that FMUs are packed for, and the tools to build for them.
#[derive(Default)]
pub struct Platforms {
    /// The platforms; none means that of this machine, without the measures for other machines.
    pub targets: Vec<&'static Target>,
    /// Where the tools to build for them are.
    pub tools: Tools,
    /// Whether WebAssembly is added to the FMUs of FMI 3.0.
    pub wasm: bool,
}

/// Name of WebAssembly among the platforms.
const WASM: &str = "wasm";

impl Platforms {
    /// The platforms with these names, with tools on the search path.
    pub fn named(names: &[String]) -> Result<Self> {
        let mut targets = Vec::new();
        for name in names.iter().filter(|name| *name != WASM) {
            let target = Target::named(name)?;
            if !targets.contains(&target) {
                targets.push(target);
            }
        }
        Ok(Self {
            targets,
            tools: Tools::default(),
            wasm: names.iter().any(|name| name == WASM),
        })
    }

    /// Refuses platforms for which this machine lacks tools, all of them before anything is built.
    fn check_tools(&self) -> Result<()> {
        let wasm = self.wasm.then_some(&target::WASM);
        let all = self.targets.iter().copied().chain(wasm);
        let faults = all.filter_map(|target| target.fault(&self.tools));
        let faults = Vec::from_iter(faults);
        ensure!(faults.is_empty(), "{}", faults.join("\n"));
        Ok(())
    }
}

/// Folder for FMUs of FMI 3.0, in that of the FMUs of FMI 2.0.
pub const FMI3_FOLDER: &str = "fmi3";

/// Builds and packs FMUs of FMI 2.0 into the folder `out`, and of FMI 3.0 into [`FMI3_FOLDER`]
/// there. Returns the files of FMI 2.0; for a model with types that only FMI 3.0 has, that of FMI
/// 3.0.
pub fn fmus(
    workspace: &Workspace,
    sources: &[Source],
    profile: &[String],
    platforms: &Platforms,
    out: &Path,
) -> Result<Vec<PathBuf>> {
    ensure!(
        !sources.is_empty(),
        "no package here makes an FMU: it needs crate-type = [\"cdylib\"] in [lib] and fmu-export among its dependencies"
    );
    let Platforms { targets, tools, .. } = platforms;
    ensure!(
        targets.is_empty() || targets.iter().any(|t| t.platform.is_in_fmi2()),
        "FMI 2.0 has no folder for {}; name another platform, too",
        targets[0].platform.folder
    );
    platforms.check_tools()?;
    check_sizes(&workspace.sizes)?;
    // The library that this machine can load comes first: it knows whether the sizes are allowed.
    let mut targets = targets.clone();
    targets.sort_by_key(|t| platform::host().map_or(true, |host| t.platform != host));
    let is_host = |t: &&&Target| platform::host().is_ok_and(|host| t.platform == host);
    // For each source one library for each platform; and those that this machine can load to get
    // the other files.
    let mut libraries = vec![Vec::new(); sources.len()];
    let mut loaded = None;
    if !targets.first().is_some_and(|t| is_host(&t)) {
        loaded = Some(workspace.build(sources, profile)?);
    }
    for target in &targets {
        if let (Some(built), false) = (&loaded, workspace.sizes.is_empty()) {
            for (library, _) in built {
                library::exported_files(library, Version::Fmi3)?;
            }
        }
        let build = target.build(workspace, tools)?;
        let built = workspace.build_with(build, sources, profile)?;
        for (libraries, (library, _)) in libraries.iter_mut().zip(&built) {
            libraries.push(read_portable(workspace, target, library)?);
        }
        loaded = loaded.or(is_host(&target).then_some(built));
    }
    let built = loaded.unwrap_or_default();
    if targets.is_empty() {
        for (libraries, (library, _)) in libraries.iter_mut().zip(&built) {
            libraries.push(read(library)?);
        }
    }
    let out_3 = out.join(FMI3_FOLDER);
    fs::create_dir_all(&out_3).with_context(|| out_3.display().to_string())?;
    let notices = Notices::new(workspace)?;
    let triples: Vec<_> = targets.iter().map(|target| target.triple).collect();
    let packed = built
        .iter()
        .zip(libraries)
        .map(|((library, package), libraries)| {
            let notices = notices.files(workspace, &package.name, &triples)?;
            let others = package_files(workspace, package, notices)?;
            let of_3 = pack_fmu(Version::Fmi3, library, &libraries, &others, &out_3)?;
            let of_2 = pack_fmu(Version::Fmi2, library, &libraries, &others, out);
            if of_2.is_ok() {
                tell_clocks(library)?;
            }
            of_2.or_else(|error| {
                let lacking = error.downcast::<UnsupportedType>()?;
                eprintln!("not packed for FMI 2.0: {lacking}");
                Ok(of_3)
            })
        });
    packed.collect()
}

/// Refuses sizes that are no NAME=NUMBER; whether the model has them, its library knows.
fn check_sizes(sizes: &[String]) -> Result<()> {
    for size in sizes {
        let parts = size.split_once('=');
        let is_size = |(name, number): (&str, &str)| {
            let is_name = !name.is_empty() && !name.contains(char::is_whitespace);
            is_name && number.parse::<i32>().is_ok_and(|n| n > 0)
        };
        ensure!(
            parts.is_some_and(is_size),
            "--size {size}: it must be the name of a structural parameter and a whole number of at least 1, such as n=200"
        );
    }
    let names: Vec<_> = sizes
        .iter()
        .filter_map(|size| Some(size.split_once('=')?.0))
        .collect();
    let twice = (1..names.len()).find(|k| names[..*k].contains(&names[*k]));
    ensure!(
        twice.is_none(),
        "--size {}: is given twice",
        names[twice.unwrap_or(0)]
    );
    Ok(())
}

/// Says what becomes of a model's clocks in FMI 2.0.
fn tell_clocks(library: &Path) -> Result<()> {
    let files = library::exported_files(library, Version::Fmi3)?;
    let variables = library::description(&files)?.variables;
    let clocks = variables.iter().filter(|v| v.kind == Kind::Clock);
    let names = Vec::from_iter(clocks.map(|v| format!("`{}`", v.name)));
    if !names.is_empty() {
        let names = names.join(", ");
        eprintln!("FMI 2.0 has no clocks: the ticks of {names} are time events of the FMU there");
    }
    Ok(())
}

/// The FMUs of FMI 3.0 that were packed with these of FMI 2.0, in the same order.
pub fn fmi3_files(fmus: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let beside = |fmu: &PathBuf| {
        let (folder, name) = (fmu.parent()?, fmu.file_name()?);
        let beside = match folder.ends_with(FMI3_FOLDER) {
            true => fmu.clone(),
            false => folder.join(FMI3_FOLDER).join(name),
        };
        Some(beside).filter(|path| path.is_file())
    };
    let missing =
        |fmu: &PathBuf| format!("there is no FMU of FMI 3.0 for {} in fmi3/", fmu.display());
    let of_3 = |fmu| beside(fmu).with_context(|| missing(fmu));
    fmus.iter().map(of_3).collect()
}

/// The platform of a library, by its own header, and its bytes.
type Library = (Platform, Vec<u8>);

fn read(library: &Path) -> Result<Library> {
    let name = || library.display().to_string();
    let bytes = fs::read(library).with_context(name)?;
    Ok((platform::detect(&bytes).with_context(name)?, bytes))
}

/// Reads a library that must run on any machine of a platform.
fn read_portable(workspace: &Workspace, target: &Target, library: &Path) -> Result<Library> {
    let (platform, bytes) = read(library)?;
    let faults = target.faults(&bytes, workspace)?;
    let path = library.display();
    ensure!(
        faults.is_empty(),
        "{path} is not for every machine of {}: it {}",
        target.platform.folder,
        faults.join("; it ")
    );
    Ok((platform, bytes))
}

/// Packs the FMU of a version of FMI; returns its file.
fn pack_fmu(
    version: Version,
    loaded: &Path,
    libraries: &[Library],
    others: &Entries,
    out: &Path,
) -> Result<PathBuf> {
    let mut entries = library::exported_files(loaded, version)?;
    let description = library::description(&entries);
    let description = description.with_context(|| loaded.display().to_string())?;
    let about = about(library::description_text(&entries)?).to_owned();
    let has = |name: &str| description.variables.iter().any(|v| v.name == name);
    ensure!(
        !is_left_over(&about, has),
        "{}: the model's description is still that of the template, `{about}`: write your own in the doc comment above the struct with \
         #[derive(State)], or in `Info::new`",
        loaded.display()
    );
    let identifier = description.identifier;
    for (platform, bytes) in libraries {
        if let Some(path) = platform.library(version, &identifier) {
            entries.insert(path, bytes.clone());
        }
    }
    for (path, bytes) in others {
        let path = match (version, path.as_str()) {
            (Version::Fmi3, "model.png") => ICON_3,
            (_, path) => path,
        };
        let entry = entries.entry(path.to_string());
        entry.or_insert_with(|| match path {
            "documentation/index.html" => described(bytes, &about),
            _ => bytes.clone(),
        });
    }
    let path = out.join(identifier).with_extension("fmu");
    let size = entries::write(&path, &entries)?;
    println!("packed {} ({} kB)", path.display(), size / 1000);
    Ok(path)
}

/// Descriptions of the models of `cargo fmu new`, which are to be replaced, and some variables.
const TEMPLATES: [(&str, [&str; 3]); 5] = [
    ("A first-order lag", ["time_constant", "u", "y"]),
    (
        "Conduction of heat in a rod whose ends are held at two temperatures",
        ["length", "area", "conductivity"],
    ),
    (
        "A motor with the efficiency of a map, and one heat node",
        ["speed", "torque", "P_loss"],
    ),
    (
        "Lithium-ion cells in series: open-circuit voltage, series resistance, one RC pair, one heat node",
        ["R_0", "soc", "v_1"],
    ),
    (
        "an oven with a thermostat",
        ["conductance", "temperature", "heating"],
    ),
];

/// Whether the description is that of a template whose variables are gone.
fn is_left_over(about: &str, has: impl Fn(&str) -> bool) -> bool {
    let mut templates = TEMPLATES.iter().filter(|(text, _)| *text == about);
    templates.any(|(_, variables)| !variables.iter().all(|name| has(name)))
}

/// The model's description, escaped as it is in its XML; empty if there is none.
fn about(model_description: &str) -> &str {
    let root = model_description.find("<fmiModelDescription");
    let root = root.map_or("", |at| &model_description[at..]);
    let root = root.split_once('>').map_or("", |(root, _)| root);
    let text = root
        .split_once(" description=\"")
        .map_or("", |(_, text)| text);
    text.split_once('"').map_or("", |(text, _)| text)
}

/// A page of documentation, in which a comment stands for the model's description.
fn described(page: &[u8], about: &str) -> Vec<u8> {
    match std::str::from_utf8(page) {
        Ok(page) => page
            .replace("<!-- description -->", &format!("<p>{about}</p>"))
            .into_bytes(),
        Err(_) => page.to_vec(),
    }
}

/// The icon in an FMU of FMI 3.0.
const ICON_3: &str = "terminalsAndIcons/icon.png";

/// What a library does not carry itself: licences, notices, and files next to the package's
/// Cargo.toml.
fn package_files(workspace: &Workspace, package: &Package, notices: Entries) -> Result<Entries> {
    let folders = [package.folder(), &workspace.root];
    let mut entries = licences::files(&folders, package.license.as_deref())?;
    let notices = notices
        .into_iter()
        .map(|(name, bytes)| (format!("{}/{name}", licences::FOLDER), bytes));
    for (path, bytes) in notices.chain(files_by_convention(package.folder())?) {
        entries.entry(path).or_insert(bytes);
    }
    reference::place(&mut entries)?;
    Ok(entries)
}

/// The files next to a package's Cargo.toml that belong into its FMU: `model.png`, and all in
/// `documentation/`, `resources/` and `reference/`. Files of the same names in the library take precedence.
fn files_by_convention(folder: &Path) -> Result<Entries> {
    let mut found = Entries::new();
    let mut left =
        Vec::from(["model.png", "documentation", "resources", reference::SOURCE].map(String::from));
    while let Some(name) = left.pop() {
        let path = folder.join(&name);
        if path.is_dir() {
            for entry in fs::read_dir(&path).with_context(|| path.display().to_string())? {
                let file = entry?.file_name().into_string();
                let file = file.map_err(|file| anyhow!("{file:?} in {name}/ must be UTF-8"))?;
                if !file.starts_with('.') {
                    left.push(format!("{name}/{file}"));
                }
            }
        } else if path.is_file() {
            let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
            found.insert(name, bytes);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::{
        Platforms, TEMPLATES, about, check_sizes, described, files_by_convention, is_left_over,
        profile,
    };
    use crate::target::TARGETS;
    use std::fs;

    #[test]
    fn files_beside_the_manifest_are_found_by_name() {
        let folder = tempfile::TempDir::new().unwrap();
        let write = |name: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name).unwrap();
        };
        let wanted = ["documentation/index.html", "model.png", "resources/a/b.txt"];
        wanted.into_iter().for_each(write);
        ["model.svg", "resources/.hidden", "src/lib.rs"]
            .into_iter()
            .for_each(write);
        let found = files_by_convention(folder.path()).unwrap();
        assert_eq!(found.keys().collect::<Vec<_>>(), wanted);
        assert_eq!(found["model.png"], b"model.png");
    }

    #[test]
    fn sizes_are_refused_before_anything_is_built() {
        let check =
            |sizes: &[&str]| check_sizes(&Vec::from_iter(sizes.iter().map(ToString::to_string)));
        check(&["n=200", "motor.m=3"]).unwrap();
        for wrong in [
            "n",
            "n=",
            "n=0",
            "n=-3",
            "n=2.5",
            "=3",
            "n=x",
            "n m=3",
            "n=99999999999",
        ] {
            let error = check(&[wrong]).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("--size {wrong}: it must be")),
                "{error}"
            );
        }
        let error = check(&["n=2", "m=1", "n=3"]).unwrap_err().to_string();
        assert_eq!(error, "--size n: is given twice");
    }

    /// A line for each platform that lacks some, in their order.
    #[test]
    fn all_missing_tools_are_named_at_once() {
        let platforms = Platforms {
            targets: TARGETS.iter().collect(),
            ..Platforms::default()
        };
        let lacking = platforms
            .targets
            .iter()
            .filter(|t| !t.missing(&platforms.tools).is_empty());
        let lacking = Vec::from_iter(lacking.map(|t| t.platform.folder));
        match platforms.check_tools() {
            Ok(()) => assert!(lacking.is_empty()),
            Err(error) => {
                let text = error.to_string();
                let lines: Vec<_> = text
                    .lines()
                    .map(|line| line.split(' ').next().unwrap())
                    .collect();
                assert_eq!(lines, lacking, "{text}");
            }
        }
    }

    #[test]
    fn the_description_of_a_template_is_refused_with_another_model() {
        let sources = [
            include_str!("../template/src/lib.rs.in"),
            include_str!("../template/rod/lib.rs"),
            include_str!("../template/map/lib.rs"),
            include_str!("../template/battery/lib.rs"),
            include_str!("../template/events/lib.rs"),
        ];
        for ((about, variables), source) in TEMPLATES.iter().zip(sources) {
            let is_there = [format!("\n/// {about}\n"), format!("\"{about}\")")];
            assert!(is_there.iter().any(|text| source.contains(text)), "{about}");
            for name in variables {
                assert!(
                    source.contains(&format!("\n    {name}: ")),
                    "{about}: {name}"
                );
                assert!(is_left_over(about, |other| other != *name));
            }
            assert!(!is_left_over(about, |_| true));
        }
        assert!(!is_left_over("A lag of mine", |_| false));
    }

    #[test]
    fn a_page_has_the_description_of_the_model() {
        let xml = "<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"2.0\" description=\"hot &amp; cold\" x=\"y\">\n<A description=\"no\"/>";
        assert_eq!(about(xml), "hot &amp; cold");
        assert_eq!(about("<fmiModelDescription><A description=\"no\"/>"), "");
        let template = include_bytes!("../template/documentation/index.html.in");
        let page = String::from_utf8(described(template, about(xml))).unwrap();
        assert!(
            page.contains("\n<p>hot &amp; cold</p>\n") && !page.contains("lag"),
            "{page}"
        );
    }

    #[test]
    fn every_profile_unwinds_and_only_ours_is_defined() {
        let release = profile("release").join(" ");
        assert!(release.starts_with("--profile release --config profile.release.panic=\"unwind\""));
        assert!(!release.contains("inherits"));
        assert!(
            profile(super::FMU_PROFILE)
                .join(" ")
                .contains("profile.fmu-release.inherits=\"release\"")
        );
    }
}
