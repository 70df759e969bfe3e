# Formula of a tap: homebrew-extricate/Formula/extricate.rb.
class Extricate < Formula
  desc "Nearest collision-free configuration of a robot in collision"
  homepage "@HOMEPAGE@"
  url "@REPOSITORY@/releases/download/v@VERSION@/extricate-source-@VERSION@.tar.gz"
  sha256 "@SHA256:extricate-source-@VERSION@.tar.gz@"
  license any_of: ["MIT", "Apache-2.0"]

  depends_on "rust" => :build

  def install
    system "cargo", "install", "--profile", "dist", *std_cargo_args(path: "crates/extricate-cli")
    generate_completions_from_executable(bin/"extricate", "completions", shells: [:bash, :fish, :zsh])
    system bin/"extricate", "man", buildpath/"man"
    man1.install Dir["man/*.1"]
  end

  test do
    system bin/"extricate", "demo", "--export", testpath/"cell"
    assert_match "joint", shell_output("#{bin}/extricate info #{testpath}/cell/shelf-arm.toml")
  end
end
